"""Box: a search space of Optuna as a parameter space of one segment, with the same range on every axis."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from optuna.distributions import BaseDistribution, FloatDistribution, IntDistribution, distribution_to_json

from hotlap.core.parameters import ParameterSpace

Floats = NDArray[np.float64]

WIDTH = 5.0  # of every axis in natural logarithms, about that of the weights of a controller, for which the tuners' steps are made


@dataclass(frozen=True)
class Axis:
    """One parameter as a share of its range, 0 to 1; on a grid, all values have shares of equal width.

    Attributes:
        name: name of the parameter.
        distribution: its range and grid, and whether it is logarithmic.
    """

    name: str
    distribution: FloatDistribution | IntDistribution

    @property
    def _ends(self) -> tuple[float, float]:
        """Ends of the range, extended by half a step of the grid; their logarithms where it is logarithmic."""
        beyond = 0.5 * (self.distribution.step or 0.0)
        low, high = self.distribution.low - beyond, self.distribution.high + beyond
        return (math.log(low), math.log(high)) if self.distribution.log else (low, high)

    def encode(self, value: float) -> float:
        """The share of a value."""
        low, high = self._ends
        return ((math.log(value) if self.distribution.log else value) - low) / (high - low)

    def decode(self, share: float) -> float | int:
        """The value at a share, on the grid where there is one."""
        low, high = self._ends
        value = low + share * (high - low)
        value = math.exp(value) if self.distribution.log else value
        least, step = self.distribution.low, self.distribution.step
        if step is not None:
            value = least + round((value - least) / step) * step
        value = min(max(value, least), self.distribution.high)
        return round(value) if isinstance(self.distribution, IntDistribution) else float(value)


@dataclass(frozen=True)
class Box:
    """K axes.

    Attributes:
        axes: in the order of the parameter space.
    """

    axes: tuple[Axis, ...]

    @classmethod
    def of(cls, search_space: Mapping[str, BaseDistribution]) -> Box:
        """The axes of the numeric parameters of a search space that have more than one value."""
        numeric = {name: each for name, each in search_space.items() if isinstance(each, FloatDistribution | IntDistribution)}
        return cls(tuple(Axis(name, each) for name, each in sorted(numeric.items()) if not each.single()))

    @property
    def space(self) -> ParameterSpace:
        """Parameters exp(WIDTH * share), which are positive, as tuners need; a step in their logarithms is a step of the share."""
        one = np.ones(len(self.axes))
        return ParameterSpace(tuple(axis.name for axis in self.axes), one, np.exp(WIDTH) * one, np.exp(WIDTH / 2) * one, one)

    @property
    def fingerprint(self) -> str:
        """Sixteen hexadecimal digits that change with the name or range of any axis."""
        text = json.dumps([[axis.name, distribution_to_json(axis.distribution)] for axis in self.axes])
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def holds(self, params: Mapping[str, Any]) -> bool:
        """Whether a trial has a value on every axis, within the range."""
        return all(axis.name in params and axis.distribution.low <= params[axis.name] <= axis.distribution.high for axis in self.axes)

    def encode(self, params: Mapping[str, Any]) -> Floats:
        """Values as parameters of one segment, shape (1, K)."""
        return np.exp(WIDTH * np.array([[axis.encode(params[axis.name]) for axis in self.axes]]))

    def decode(self, parameters: Floats) -> dict[str, float | int]:
        """The values at parameters of shape (1, K)."""
        return self.of_shares(np.log(parameters[0]) / WIDTH)

    def of_shares(self, shares: Floats) -> dict[str, float | int]:
        """The values at shares of the ranges, shape (K,)."""
        return {axis.name: axis.decode(share) for axis, share in zip(self.axes, shares.tolist(), strict=True)}
