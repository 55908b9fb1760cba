"""The lines that draw a drone in space: arms and rotors where the vehicle has them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_ANGLES = np.linspace(0, 2 * np.pi, 17)
_DISC = 0.62 * np.stack([np.cos(_ANGLES), np.sin(_ANGLES), np.zeros(17)], axis=1)  # a rotor, of an arm of 1


def turn(attitude: Floats, vectors: Floats) -> Floats:
    """Body vectors, shape (n, 3), in the world.

    Args:
        attitude: shape (4,) (w, x, y, z), body to world.
        vectors: shape (n, 3).
    """
    w, axis = attitude[0], attitude[1:]
    twice = 2 * np.cross(axis, vectors)
    return vectors + w * twice + np.cross(axis, twice)


def draw_drone(position: Floats, attitude: Floats, size: float, rotors: Floats) -> list[Floats]:
    """Arms and rotors as lines, each shape (points, 3) [m] (world); rotors that lie opposite each other share an arm.

    Args:
        position: shape (3,) [m] (world).
        attitude: shape (4,) (w, x, y, z), body to world.
        size: [m] of an arm, as large as it should be seen.
        rotors: shape (r, 2), where they sit, in arms.
    """
    hubs, half = np.pad(rotors, ((0, 0), (0, 1))), len(rotors) // 2  # in the plane of the arms
    opposite = len(rotors) % 2 == 0 and np.allclose(hubs[:half], -hubs[half:])
    arms = list(np.stack([hubs[:half], hubs[half:]], axis=1)) if opposite else [np.stack([0 * hub, hub]) for hub in hubs]
    return [position + size * turn(attitude, line) for line in (*arms, *(_DISC + hub for hub in hubs))]
