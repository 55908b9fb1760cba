"""Bodies: rigid parts of a vehicle, taken together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Body:
    """A rigid part of a vehicle.

    Attributes:
        mass: [kg].
        centre: of its mass, shape (3,) [m] (vehicle).
        inertia: about that centre, shape (3, 3) [kg m^2] (vehicle).
    """

    mass: float
    centre: Floats
    inertia: Floats


def together(bodies: Sequence[Body]) -> Body:
    """One body from all of them: I = sum of I_k + m_k (|d|^2 1 - d d^T), by the theorem of Steiner."""
    mass = sum(body.mass for body in bodies)
    centre = np.sum([body.mass * body.centre for body in bodies], axis=0) / mass
    inertia = np.zeros((3, 3))
    for body in bodies:
        d = body.centre - centre
        inertia += body.inertia + body.mass * (d @ d * np.eye(3) - np.outer(d, d))
    return Body(mass, centre, inertia)
