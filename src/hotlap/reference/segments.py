"""Segments: the parts of a reference, each of which has controller parameters of its own."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from hotlap.core.shown import Shown


class SegmentClass(StrEnum):
    """What a part of a reference does (Sec. IV-C of the paper)."""

    FLAT = "flat"
    ASCENT = "ascent"
    DESCENT = "descent"
    STEEP = "steep"


@dataclass(frozen=True)
class Piece:
    """A part of a reference.

    Attributes:
        segment: index of the segment that it belongs to.
        kind: its class.
        start, end: [s].
    """

    segment: int
    kind: SegmentClass
    start: float
    end: float


@dataclass(frozen=True, repr=False)
class Segments(Shown):
    """S segments of a reference, each of one or more of its P consecutive pieces; each segment has parameters of its own.

    Attributes:
        starts: [s] shape (P,), of the pieces, ascending; the first is 0.
        classes: P classes; the pieces of one segment are of one class.
        duration: [s] end of the last piece.
        owners: P indices, 0 to S - 1, of the segment that each piece belongs to; empty where every piece is a segment, S = P.
    """

    starts: NDArray[np.float64]
    classes: tuple[SegmentClass, ...]
    duration: float
    owners: tuple[int, ...] = ()

    def __len__(self) -> int:
        """S, the number of segments."""
        return max(self.owners) + 1 if self.owners else len(self.classes)

    @property
    def ends(self) -> NDArray[np.float64]:
        """[s] of the pieces, shape (P,)."""
        return np.append(self.starts[1:], self.duration)

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """P pieces in order."""
        owners = self.owners or range(len(self.classes))
        return tuple(map(Piece, owners, self.classes, self.starts.tolist(), self.ends.tolist()))

    @property
    def segment_classes(self) -> tuple[SegmentClass, ...]:
        """S classes, of the segments."""
        kinds = {piece.segment: piece.kind for piece in self.pieces}
        return tuple(kinds[i] for i in range(len(self)))

    def at(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """Index of the segment at each time [s]; the last piece holds for ever."""
        pieces = self.piece_at(times)
        return np.array(self.owners, dtype=np.int64)[pieces] if self.owners else pieces

    def piece_at(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """Index of the piece at each time [s]; the last one holds for ever."""
        return np.clip(np.searchsorted(self.starts, times, side="right") - 1, 0, len(self.classes) - 1)
