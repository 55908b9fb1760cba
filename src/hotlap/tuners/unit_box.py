"""Unit box: parameters scaled to [0, 1] by their bounds, for algorithms that search in a box without units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class UnitBox:
    """The map between the parameters of all segments and points of the unit box.

    Attributes:
        space: names and bounds of the parameters.
        shape: (S, K), shape of the parameters.
        log: whether it is a box of logarithms; else of the parameters' own units.
        tied: one set of parameters for all segments.
    """

    space: ParameterSpace
    shape: tuple[int, ...]
    log: bool
    tied: bool = False

    @property
    def size(self) -> int:
        """d, number of coordinates of a point."""
        return self.shape[1] if self.tied else self.shape[0] * self.shape[1]

    def encode(self, parameters: Parameters) -> Floats:
        """The point, shape (d,), of parameters of shape (S, K); tied, the mean over segments."""
        space = self.space
        unit = space.to_unit(parameters) if self.log else (parameters - space.low) / (space.high - space.low)
        return np.clip(unit.mean(axis=0) if self.tied else unit.ravel(), 0.0, 1.0)

    def decode(self, points: Floats) -> Parameters:
        """Parameters at points of shape (count, d), shape (count, S, K), within the bounds."""
        segments, size = self.shape
        unit = np.repeat(points[:, None], segments, axis=1) if self.tied else points.reshape(-1, segments, size)
        if self.log:
            return self.space.from_unit(unit)
        return self.space.clip(self.space.low + unit * (self.space.high - self.space.low))


def latin_hypercube(count: int, size: int, rng: np.random.Generator) -> Floats:
    """Points of the unit box, one in each of `count` slices of every axis, shape (count, size) (McKay, Beckman, Conover, 1979)."""
    slices = rng.permuted(np.tile(np.arange(count), (size, 1)), axis=1).T
    return (slices + rng.random((count, size))) / count
