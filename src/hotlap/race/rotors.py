"""Rotors: where they sit, which way they turn, and the torques that they make."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Rotor = tuple[float, float, float]

FEWEST, MOST = 4, 8  # rotors
LEAST_AUTHORITY = 1e-3  # smallest singular value of thrust and torques, of levers that are 1


class RotorLayout(StrEnum):
    """Where the rotors sit: on the diagonals, or on the axes."""

    X = "x"
    PLUS = "plus"


def rotor_positions(layout: RotorLayout, arm: float) -> Floats:
    """Where the four rotors sit, seen from the centre of mass, shape (4, 2) [m] (body): x forward, y left.

    Args:
        layout: on the diagonals or on the axes.
        arm: [m] distance from the centre of mass.
    """
    if layout is RotorLayout.X:
        lever = arm * math.sqrt(0.5)
        return lever * np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]])
    return arm * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])


def rotor_spins(layout: RotorLayout) -> Floats:
    """The sign of the yaw torque of each of the four rotors, shape (4,): neighbours turn against each other."""
    first = 1.0 if layout is RotorLayout.X else -1.0
    return first * np.array([1.0, -1.0, 1.0, -1.0])


def torque_matrix(layout: RotorLayout, arm: float, torque_ratio: float) -> Floats:
    """Torque (body) of each of four rotors per newton of thrust; see `torques_of`.

    Args:
        layout: where the rotors sit.
        arm: [m] distance from the centre of mass.
        torque_ratio: [m] yaw torque over thrust.

    Returns:
        Shape (3, 4) [m].
    """
    return torques_of(rotor_positions(layout, arm), rotor_spins(layout), torque_ratio)


def torques_of(positions: Floats, spins: Floats, torque_ratio: float) -> Floats:
    """Torque (body) of each rotor per newton of thrust: a rotor at (x, y) makes a roll torque of y and a pitch torque of -x.

    Args:
        positions: shape (n, 2) [m] (body).
        spins: shape (n,), sign of the yaw torque.
        torque_ratio: [m] yaw torque over thrust.

    Returns:
        Shape (3, n) [m].
    """
    x, y = positions.T
    return np.array([y, 0.0 - x, torque_ratio * spins])  # 0 - x: no negative zeros


def farthest(rotors: Sequence[Rotor]) -> float:
    """[m] Distance of the rotor that is farthest from the centre of mass."""
    return max(math.hypot(x, y) for x, y, _ in rotors)


def fault_of(rotors: Sequence[Rotor]) -> str:
    """What makes a list of rotors impossible, "" where nothing does."""
    if not FEWEST <= len(rotors) <= MOST:
        return f"there must be {FEWEST} to {MOST}, not {len(rotors)}"
    strange = next((rotor[2] for rotor in rotors if abs(rotor[2]) != 1), None)
    if strange is not None:
        return f"each is [x, y, spin], and spin is 1 or -1, not {strange:g}"
    x, y, spins = np.array(rotors).T
    if not (x.any() and y.any()):
        return "they lie on one line: roll or pitch has no lever"
    scale = max(np.abs(x).max(), np.abs(y).max())
    rows = np.array([np.ones(len(spins)), y / scale, x / scale, spins])
    if np.linalg.svd(rows, compute_uv=False)[-1] < LEAST_AUTHORITY:
        return "thrust, roll, pitch and yaw cannot be asked for one by one: of neighbours, one must turn to the left and one to the right"
    return ""
