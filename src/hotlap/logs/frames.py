"""Frames: from the axes of autopilots (north, east, down; forward, right, down) to those of hotlap (z up; forward, left, up)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hotlap.core.records import Floats

HALF_TURN = np.array([1.0, -1.0, -1.0])  # about x: north, east, down -> north, west, up, and forward, right, down -> forward, left, up
TURNED = "world: north, west, up, made from north, east, down"


def turn(vectors: ArrayLike) -> Floats:
    """Vectors, shape (N, 3), of a frame with z down in the one with z up."""
    return np.asarray(vectors, dtype=np.float64) * HALF_TURN


def turn_attitude(quaternions: ArrayLike) -> Floats:
    """Attitudes, shape (N, 4) (w, x, y, z): with both the world and the body turned about x, y and z change their signs."""
    return np.asarray(quaternions, dtype=np.float64) * np.array([1.0, 1.0, -1.0, -1.0])


def from_angles(roll: ArrayLike, pitch: ArrayLike, yaw: ArrayLike) -> Floats:
    """Attitudes, shape (N, 4), from yaw, then pitch, then roll [rad]."""
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(half), np.sin(half)) for half in (np.asarray(angle) / 2 for angle in (roll, pitch, yaw)))
    return np.stack(
        [cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy], axis=-1
    )
