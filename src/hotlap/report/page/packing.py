"""Packing: arrays and numbers as the page reads them."""

from __future__ import annotations

import base64
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

MOST_ROWS = 2500  # of a time series: more than a screen has pixels


def pack(values: ArrayLike) -> dict[str, Any]:
    """An array as base64 of little-endian float32, with its shape; NaN is allowed."""
    with np.errstate(over="ignore"):  # beyond what has 32 bits it is infinite
        array = np.ascontiguousarray(np.asarray(values, dtype="<f4"))
    return {"f32": base64.b64encode(array.tobytes()).decode("ascii"), "shape": list(array.shape)}


def number(value: float) -> float | None:
    """A number for JSON: None where it is not finite."""
    return float(value) if math.isfinite(value) else None


def numbers(values: ArrayLike) -> list[float | None]:
    """Numbers for JSON, of shape (n,)."""
    return [number(value) for value in np.asarray(values, dtype=np.float64).tolist()]


def thin(rows: int, most: int = MOST_ROWS) -> slice:
    """Selects every n-th of some rows, evenly, so that at most `most` are left."""
    return slice(None, None, max(1, math.ceil(rows / most)))
