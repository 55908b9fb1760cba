"""Kinds of number that flights are computed in, and how functions on them are compiled."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.flight.lanes import FAST_MATH

COMPILE: dict[str, Any] = {"fastmath": set(FAST_MATH), "error_model": "numpy", "nogil": True}
INNER: dict[str, Any] = {**COMPILE, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}  # called by compiled code alone: compiles faster
INLINE: dict[str, Any] = {**INNER, "forceinline": True}


CACHE_LINE = 64  # bytes


def aligned_zeros(shape: tuple[int, ...], kind: type[np.floating[Any]]) -> NDArray[np.floating[Any]]:
    """Zeros that begin with a cache line, so that no number lies across two (measured: 1.4 to 1.6 times faster)."""
    size = math.prod(shape) * np.dtype(kind).itemsize
    block = np.zeros(size + CACHE_LINE, dtype=np.uint8)
    start = -block.ctypes.data % CACHE_LINE
    return block[start : start + size].view(kind).reshape(shape)


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


def best_numbers() -> Numbers:
    """The fastest kind here: sixteen lanes where Numba compiles for AVX-512, else eight, which LLVM splits for shorter vectors.

    What Numba compiles for is the processor, unless NUMBA_CPU_NAME or NUMBA_CPU_FEATURES say otherwise.
    """
    from numba.core.registry import cpu_target  # noqa: PLC0415  the compiler takes its time to load

    context: Any = cpu_target.target_context
    _, _, features = context.codegen().magic_tuple()
    return Numbers.FLOAT32X16 if {"+avx512f", "+avx512vl"} <= set(features.split(",")) else Numbers.FLOAT32X8
