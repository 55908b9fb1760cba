"""Encoding: arrays and numbers as the page reads them, and JSON that may stand within HTML."""

from __future__ import annotations

import base64
import json
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

MOST_ROWS = 2500  # of a series: more than a screen has pixels


def pack(values: ArrayLike) -> dict[str, Any]:
    """An array as base64 of little-endian float32, with its shape; it may hold NaN."""
    array = np.ascontiguousarray(np.asarray(values, dtype="<f4"))
    return {"f32": base64.b64encode(array.tobytes()).decode("ascii"), "shape": list(array.shape)}


def number(value: float) -> float | None:
    """A number, or None where it is not finite."""
    return float(value) if math.isfinite(value) else None


def numbers(values: ArrayLike) -> list[float | None]:
    """Numbers, shape (n,)."""
    return [number(value) for value in np.asarray(values, dtype=np.float64).tolist()]


def thin(rows: int, most: int = MOST_ROWS) -> slice:
    """Every so manieth of some rows, so that no more than `most` are left."""
    return slice(None, None, max(1, math.ceil(rows / most)))


def write_json(document: dict[str, Any]) -> str:
    """One line of JSON that ends no HTML element."""
    return json.dumps(document, allow_nan=False, separators=(",", ":"), ensure_ascii=False).replace("<", "\\u003c")
