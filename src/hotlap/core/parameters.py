"""ParameterSpace: what a controller lets itself be tuned by; Parameters: values for a batch of flights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.shown import Shown

Parameters = NDArray[np.float64]
"""Values for a batch: shape (batch B, segments S, parameters K), in the units of the space; K is what the controller declares."""


@dataclass(frozen=True, repr=False)
class ParameterSpace(Shown):
    """Names, bounds and scale of a controller's parameters, the same for every segment.

    Attributes:
        names: K names.
        low, high: bounds, shape (K,).
        default: the authors' or a stated default, shape (K,).
        log_step: relative size of a step in log space, shape (K,): 1 for weights, 0.5 for the horizon.
    """

    names: tuple[str, ...]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    default: NDArray[np.float64]
    log_step: NDArray[np.float64]

    @property
    def size(self) -> int:
        """K, parameters per segment."""
        return len(self.names)

    def first_guess(self, segments: int) -> Parameters:
        """The default for every segment, shape (segments, K)."""
        return np.tile(self.default, (segments, 1))

    def contains(self, parameters: Parameters) -> bool:
        """Whether all values, shape (..., K), lie within the bounds."""
        return bool(np.all((parameters >= self.low) & (parameters <= self.high)))

    def clip(self, parameters: Parameters) -> Parameters:
        """Values moved to the nearest bound, shape (..., K)."""
        return np.clip(parameters, self.low, self.high)

    def reflect(self, parameters: Parameters) -> Parameters:
        """Values mirrored at the bounds until they lie within, shape (..., K): keeps a symmetric proposal symmetric."""
        return reflect(parameters, self.low, self.high)

    def reflect_log(self, logarithms: NDArray[np.float64]) -> NDArray[np.float64]:
        """The same for logarithms of values, shape (..., K)."""
        return reflect(logarithms, np.log(self.low), np.log(self.high))

    def to_unit(self, parameters: Parameters) -> NDArray[np.float64]:
        """Logarithms scaled so that the bounds become 0 and 1, shape (..., K)."""
        low, high = np.log(self.low), np.log(self.high)
        return (np.log(parameters) - low) / (high - low)

    def from_unit(self, unit: NDArray[np.float64]) -> Parameters:
        """The inverse of `to_unit`, never outside the bounds by rounding."""
        low, high = np.log(self.low), np.log(self.high)
        return self.clip(np.exp(low + unit * (high - low)))


def reflect(values: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mirror values at bounds, as often as needed."""
    width = high - low
    folded = np.mod(values - low, 2 * width)
    return np.clip(low + np.where(folded > width, 2 * width - folded, folded), low, high)
