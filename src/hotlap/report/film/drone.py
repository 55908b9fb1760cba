"""The lines that draw a drone in space: arms and rotors where the vehicle has them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hotlap.race.rotors import RotorLayout, rotor_positions

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


def draw_drone(position: Floats, attitude: Floats, size: float, layout: RotorLayout) -> list[Floats]:
    """Two arms and four rotors as lines, each shape (points, 3) [m] (world).

    Args:
        position: shape (3,) [m] (world).
        attitude: shape (4,) (w, x, y, z), body to world.
        size: [m] of an arm, as large as it should be seen.
        layout: where the rotors sit.
    """
    hubs = np.pad(rotor_positions(layout, 1.0), ((0, 0), (0, 1)))  # in the plane of the arms
    arms = [hubs[[0, 2]], hubs[[1, 3]]]
    return [position + size * turn(attitude, line) for line in (*arms, *(_DISC + hub for hub in hubs))]
