"""Subspace: a few directions of the parameter space, the same in all segments, and a lattice of candidates along them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

REACH, SPACING = 6.0, 0.25  # half width and spacing of a lattice along an axis, in units of `log_step`


class Direction(StrEnum):
    """Groups of parameters that are scaled together.

    GAIN: all but the horizon; as the input weights of an MPC stay constant, this is its gain.
    HORIZON: the prediction horizon.
    DAMPING: the weights of velocities.
    """

    GAIN = "gain"
    HORIZON = "horizon"
    DAMPING = "damping"

    def turns(self, name: str) -> bool:
        """Whether a parameter belongs to the group."""
        horizon = name == "horizon"
        return {Direction.GAIN: not horizon, Direction.HORIZON: horizon, Direction.DAMPING: "vel" in name}[self]


def axes_of(directions: Sequence[Direction], names: Sequence[str]) -> Floats:
    """Unit vectors of those directions that have any of the named parameters, shape (d, K); d may be 0."""
    turned = np.array([[float(direction.turns(name)) for name in names] for direction in directions]).reshape(-1, len(names))
    turned = turned[turned.any(axis=1)]
    return turned / np.linalg.norm(turned, axis=1, keepdims=True)


def draw_direction(axes: Floats, rng: np.random.Generator) -> Floats:
    """A random unit vector, shape (1, K), in the space spanned by axes of shape (d, K)."""
    vector = rng.standard_normal((1, len(axes))) @ axes
    return vector / np.linalg.norm(vector)


@dataclass(frozen=True)
class Lattice:
    """The points origin + axes' t, t on a grid of `SPACING` within `REACH`.

    Attributes:
        origin: shape (K,).
        axes: shape (d, K), unit vectors.
        offset: shape (d,), shift of the grid of t, 0 to `SPACING`.
    """

    origin: Floats
    axes: Floats
    offset: Floats

    def points(self, low: Floats, high: Floats) -> Floats:
        """The origin and the points of the lattice, clipped at bounds of shape (K,), without duplicates; shape (m, K)."""
        ticks = np.arange(-REACH, REACH, SPACING)
        grids = np.meshgrid(*(ticks + shift for shift in self.offset), indexing="ij")
        steps = np.stack([grid.ravel() for grid in grids], axis=1)
        points = np.vstack([self.origin, self.origin + steps @ self.axes])
        return np.unique(np.clip(points, low, high), axis=0)
