"""Turning: angles of other programs as ours."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
LOCKED = 1e-9  # below it a normal stands upright, and yaw and roll turn around the same axis
NOTHING = 1e-12  # rad: what calculation leaves of a right angle


def rotation_of(roll: float, pitch: float, yaw: float) -> Floats:
    """World from body for angles [rad] about the fixed axes x, y, z, in this order, shape (3, 3)."""
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    about_x = np.array([[1.0, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1.0, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1.0]])
    return about_z @ about_y @ about_x


def angles_of(rotation: Floats) -> dict[str, float]:
    """Yaw, pitch and roll [rad] of a gate, from the matrix whose columns are its normal, left and up; yaw is always there."""
    normal, left, up = rotation.T
    flat = math.hypot(normal[0], normal[1])
    pitch = math.atan2(-normal[2], flat)
    if flat < LOCKED:
        yaw, roll = math.atan2(-left[0], left[1]), 0.0
    else:
        yaw, roll = math.atan2(normal[1], normal[0]), math.atan2(left[2], up[2])
    yaw, pitch, roll = (0.0 if abs(angle) < NOTHING else angle for angle in (yaw, pitch, roll))
    return {"yaw": yaw, **({"pitch": pitch} if pitch else {}), **({"roll": roll} if roll else {})}


def quaternion_of(roll: float, pitch: float, yaw: float) -> list[float]:
    """(w, x, y, z), world from body, for angles [rad] about the fixed axes x, y, z, in this order."""
    cr, sr, cp, sp, cy, sy = (f(a / 2) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return [cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy]


def is_level(attitude: Sequence[float]) -> bool:
    """Whether a quaternion (w, x, y, z) does not turn anything."""
    return bool(np.allclose(np.abs(attitude), [1, 0, 0, 0]))
