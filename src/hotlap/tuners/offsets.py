"""Offsets: logarithm of the ratio of parameters to the first guess, in units of the space's `log_step`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Offsets:
    """The map between parameters and their offsets from the first guess.

    Attributes:
        space: names, bounds and step sizes of the parameters.
        first: shape (S, K), the first guess, within the bounds.
        tied: the same offset in all segments.
    """

    space: ParameterSpace
    first: Parameters
    tied: bool

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Smallest and largest offsets, each of shape (d,); tied, those at which the last segment reaches its bound."""
        low, high = (np.log(bound / self.first) / self.space.log_step for bound in (self.space.low, self.space.high))
        return (low.min(axis=0), high.max(axis=0)) if self.tied else (low.ravel(), high.ravel())

    def decode(self, offsets: Floats) -> Parameters:
        """Parameters at offsets of shape (count, d), shape (count, S, K), within the bounds."""
        steps = offsets.reshape(len(offsets), -1, self.space.size) * self.space.log_step
        return self.space.clip(self.first * np.exp(steps))
