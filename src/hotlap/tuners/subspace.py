"""Subspace: few directions in which an engineer turns all segments alike, and a lattice of candidates along them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

REACH, SPACING = 6.0, 0.25  # of a lattice along an axis, in steps of `log_step`


class Direction(StrEnum):
    """What is turned.

    GAIN: all but the horizon; since the weights of an MPC's inputs stay, this is how aggressively it corrects.
    HORIZON: how far the controller looks ahead.
    DAMPING: all that is named after velocity.
    """

    GAIN = "gain"
    HORIZON = "horizon"
    DAMPING = "damping"

    def turns(self, name: str) -> bool:
        """Whether a parameter takes part."""
        horizon = name == "horizon"
        return {Direction.GAIN: not horizon, Direction.HORIZON: horizon, Direction.DAMPING: "vel" in name}[self]


def axes_of(directions: Sequence[Direction], names: Sequence[str]) -> Floats:
    """Unit vectors along those directions that turn any of the named parameters, shape (d, K), with d from 0."""
    turned = np.array([[float(direction.turns(name)) for name in names] for direction in directions]).reshape(-1, len(names))
    turned = turned[turned.any(axis=1)]
    return turned / np.linalg.norm(turned, axis=1, keepdims=True)


def draw_direction(axes: Floats, rng: np.random.Generator) -> Floats:
    """A random unit vector in the space of some axes, shape (d, K); shape (1, K)."""
    vector = rng.standard_normal((1, len(axes))) @ axes
    return vector / np.linalg.norm(vector)


@dataclass(frozen=True)
class Lattice:
    """Points at origin + axes' t, with t at a spacing.

    Attributes:
        origin: shape (K,).
        axes: shape (d, K), unit vectors.
        offset: shape (d,), of t from the origin, 0 to `SPACING`.
    """

    origin: Floats
    axes: Floats
    offset: Floats

    def points(self, low: Floats, high: Floats) -> Floats:
        """The origin and the lattice, clipped at bounds of shape (K,), each once; shape (m, K)."""
        ticks = np.arange(-REACH, REACH, SPACING)
        grids = np.meshgrid(*(ticks + shift for shift in self.offset), indexing="ij")
        steps = np.stack([grid.ravel() for grid in grids], axis=1)
        points = np.vstack([self.origin, self.origin + steps @ self.axes])
        return np.unique(np.clip(points, low, high), axis=0)
