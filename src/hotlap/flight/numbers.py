"""Kinds of number that flights are computed in, and how functions on them are compiled."""

from __future__ import annotations

from enum import StrEnum
from typing import Any

import numpy as np

from hotlap.flight.lanes import FAST_MATH

COMPILE: dict[str, Any] = {"fastmath": set(FAST_MATH), "error_model": "numpy", "nogil": True}
INLINE: dict[str, Any] = {**COMPILE, "forceinline": True}


class Numbers(StrEnum):
    """What one number of the flight core is: one float64, or a SIMD vector that flies one flight a lane."""

    FLOAT64 = "float64"
    FLOAT64X4 = "float64x4"
    FLOAT32X8 = "float32x8"
    FLOAT32X16 = "float32x16"

    @property
    def width(self) -> int:
        """Lanes; 0 for plain floats."""
        return int(self.partition("x")[2] or 0)

    @property
    def lanes(self) -> int:
        """Flights at a time, at least 1."""
        return max(self.width, 1)

    @property
    def dtype(self) -> type[np.floating[Any]]:
        """Of one lane."""
        return np.float32 if self.startswith("float32") else np.float64
