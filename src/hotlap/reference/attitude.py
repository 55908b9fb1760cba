"""Attitude: quaternions that follow a thrust axis, and the body rates between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


def product(a: Floats, b: Floats) -> Floats:
    """a o b, Hamilton's product, of quaternions (w, x, y, z) along the last axis."""
    w = a[..., :1] * b[..., :1] - (a[..., 1:] * b[..., 1:]).sum(axis=-1, keepdims=True)
    return np.concatenate([w, a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])], axis=-1)


def thrust_axis(attitudes: Floats) -> Floats:
    """Body z in the world of unit quaternions, shape (..., 4) -> (..., 3)."""
    w, x, y, z = np.moveaxis(attitudes, -1, 0)
    return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)


def rotation_matrices(attitudes: Floats) -> Floats:
    """Rotations from body to world of unit quaternions, shape (..., 4) -> (..., 3, 3)."""
    w, x, y, z = np.moveaxis(attitudes, -1, 0)
    rows = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return np.moveaxis(rows, (0, 1), (-2, -1))


def follow_axes(axes: Floats, attitude: Floats, largest_turn: float = np.pi) -> Floats:
    """Attitudes whose body z follows given unit vectors by the shortest rotations.

    Args:
        axes: shape (count, 3) (world).
        attitude: shape (4,) the one to turn first, towards the first axis.
        largest_turn: [rad] from one attitude to the next; axes that run away are caught up with later.

    Returns:
        Shape (count, 4).
    """
    attitudes = []
    for axis in axes:
        attitude = product(_turn(thrust_axis(attitude), axis, largest_turn), attitude)
        attitude = attitude / np.linalg.norm(attitude)
        attitudes.append(attitude)
    return np.array(attitudes).reshape(-1, 4)


def turn_rates(attitudes: Floats, steps: Floats | float) -> Floats:
    """Constant rates that take each attitude to the next, shape (count - 1, 3) [rad/s] (body).

    Args:
        attitudes: shape (count, 4).
        steps: shape (count - 1,) [s] between them, or one for all.
    """
    turns = product(attitudes[:-1] * CONJUGATE, attitudes[1:])
    turns = turns * np.where(turns[:, :1] < 0, -1.0, 1.0)
    sines = np.linalg.norm(turns[:, 1:], axis=1)
    angles = 2 * np.arctan2(sines, turns[:, 0])
    scale = np.where(sines > 1e-12, angles / np.maximum(sines, 1e-12), 2.0)
    return turns[:, 1:] * (scale / steps)[:, None]


def continuous(attitudes: Floats) -> Floats:
    """The same attitudes without sign jumps, shape (count, 4)."""
    jumps = np.einsum("ij,ij->i", attitudes[1:], attitudes[:-1]) < 0
    return attitudes * np.cumprod(np.append(1.0, np.where(jumps, -1.0, 1.0)))[:, None]


def _turn(start: Floats, end: Floats, largest: float) -> Floats:
    """The shortest rotation (world) of one unit vector to another, cut short at an angle [rad]."""
    across = np.cross(start, end)
    sine = np.linalg.norm(across)
    if sine < 1e-6 and start @ end < 0:  # opposite: every axis across is as short
        across = np.cross(start, np.eye(3)[np.argmin(np.abs(start))])
    angle = min(np.arctan2(sine, start @ end), largest)
    return np.append(np.cos(angle / 2), across / max(np.linalg.norm(across), 1e-12) * np.sin(angle / 2))


def rotate(attitudes: Floats, vectors: Floats) -> Floats:
    """Vectors (body) in the world: q o v o conj(q), shape (count, 3).

    Args:
        attitudes: shape (count, 4), of norm 1.
        vectors: shape (count, 3).
    """
    middle = product(attitudes, np.hstack([np.zeros((len(vectors), 1)), vectors]))
    return product(middle, attitudes * CONJUGATE)[:, 1:]
