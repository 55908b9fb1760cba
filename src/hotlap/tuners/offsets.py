"""Offsets: parameters as steps away from the first guess, in logarithms and units of the space's `log_step`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Offsets:
    """How far all parameters are from the first guess.

    Attributes:
        space: what can be tuned.
        first: shape (S, K), the first guess, within the bounds.
        tied: one offset for all segments.
    """

    space: ParameterSpace
    first: Parameters
    tied: bool

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Least and largest offsets, each of shape (d,); tied, as far as any segment may go."""
        low, high = (np.log(bound / self.first) / self.space.log_step for bound in (self.space.low, self.space.high))
        return (low.min(axis=0), high.max(axis=0)) if self.tied else (low.ravel(), high.ravel())

    def decode(self, offsets: Floats) -> Parameters:
        """Parameters at offsets of shape (count, d), shape (count, S, K), within the bounds."""
        steps = offsets.reshape(len(offsets), -1, self.space.size) * self.space.log_step
        return self.space.clip(self.first * np.exp(steps))
