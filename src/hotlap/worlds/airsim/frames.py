"""Frames: states as AirSim says them, in a world of north, east, down and a body of front, right, down, and ours.

Both frames turn into ours by half a turn about their x axis: y and z change sign, of vectors and of the quaternion's vector part.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.files.content import Content

Floats = NDArray[np.float64]
VECTOR, QUATERNION = ("x_val", "y_val", "z_val"), ("w_val", "x_val", "y_val", "z_val")
HALF_TURN = np.array([1.0, -1.0, -1.0])


def vector_of(content: Content) -> Floats:
    """A vector of AirSim, in our frame, shape (3,).

    Raises:
        InputError: it is none, or not finite.
    """
    return HALF_TURN * [content[name].number() for name in VECTOR]


def attitude_of(content: Content) -> Floats:
    """An attitude (w, x, y, z) of AirSim, body to world in our frames, shape (4,), of norm 1.

    Raises:
        InputError: it is none, or not finite.
    """
    attitude = np.array([1.0, *HALF_TURN]) * [content[name].number() for name in QUATERNION]
    norm = float(np.linalg.norm(attitude))
    if not 0.5 < norm < 2:
        raise content.fault(f"must be a quaternion of norm 1, not {norm:.3g}")
    return attitude / norm


def rotation_of(content: Content) -> Floats:
    """World from body, shape (3, 3): the columns are the body's front, right and down, in our world.

    Raises:
        InputError: it is none, or not finite.
    """
    w, x, y, z = attitude_of(content)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows) * HALF_TURN


def state_of(kinematics: Content) -> Floats:
    """Position, attitude, velocity and body rates, shape (13,), of what AirSim calls kinematics.

    Raises:
        InputError: something is missing or not finite.
    """
    position, attitude = vector_of(kinematics["position"]), attitude_of(kinematics["orientation"])
    velocity, rates = vector_of(kinematics["linear_velocity"]), vector_of(kinematics["angular_velocity"])
    return np.concatenate([position, attitude, velocity, rates])


def kinematics_of(state: Floats) -> dict[str, Any]:
    """What AirSim calls kinematics, of a state, shape (13,), without accelerations."""
    return {
        **pose_of(state),
        "linear_velocity": _vector(state[7:10]),
        "angular_velocity": _vector(state[10:13]),
        "linear_acceleration": _vector(np.zeros(3)),
        "angular_acceleration": _vector(np.zeros(3)),
    }


def pose_of(state: Floats) -> dict[str, Any]:
    """What AirSim calls a pose, of a state, shape (7,) or more."""
    attitude = np.array([1.0, *HALF_TURN]) * state[3:7]
    return {"position": _vector(state[:3]), "orientation": _table(QUATERNION, attitude)}


def _vector(vector: Floats) -> dict[str, float]:
    """A vector of ours, in AirSim's frame."""
    return _table(VECTOR, HALF_TURN * vector)


def _table(names: Sequence[str], numbers: Floats) -> dict[str, float]:
    return {name: float(number) for name, number in zip(names, numbers, strict=True)}
