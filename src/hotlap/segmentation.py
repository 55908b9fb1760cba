"""Segments: the parts of a reference that have parameters of their own (Sec. IV-C of the paper)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray


class SegmentClass(StrEnum):
    """What a part of a reference does."""

    FLAT = "flat"
    ASCENT = "ascent"
    DESCENT = "descent"
    STEEP = "steep"


@dataclass(frozen=True)
class Segments:
    """Consecutive parts of a reference.

    Attributes:
        starts: [s] shape (S,), ascending; the first is 0.
        classes: S classes.
        duration: [s] end of the last segment.
    """

    starts: NDArray[np.float64]
    classes: tuple[SegmentClass, ...]
    duration: float

    def __len__(self) -> int:
        """S, the number of segments."""
        return len(self.classes)

    @property
    def ends(self) -> NDArray[np.float64]:
        """[s] shape (S,)."""
        return np.append(self.starts[1:], self.duration)

    def at(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """Index of the segment at each time [s]; the last one holds for ever."""
        return np.clip(np.searchsorted(self.starts, times, side="right") - 1, 0, len(self) - 1)
