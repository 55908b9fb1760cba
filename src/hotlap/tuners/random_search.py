"""Random search: independent random parameters, whatever the scores; the baseline of every tuner."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores


class Draw(StrEnum):
    """Distribution of the parameters.

    AROUND: uniform around the first guess, independent axes, mirrored at the bounds.
    UNIFORM: uniform within the bounds, independent axes.
    LOG_UNIFORM: uniform in logarithms within the bounds, the same in all segments.
    """

    AROUND = "around"
    UNIFORM = "uniform"
    LOG_UNIFORM = "log_uniform"


@dataclass(frozen=True)
class RandomSearchSettings:
    """Settings of random search.

    Attributes:
        draw: distribution of the parameters.
        variance: variance of each axis, in its own unit squared, for AROUND.
    """

    draw: Draw
    variance: float = 5.0


PRESETS: Mapping[str, RandomSearchSettings] = {
    "paper": RandomSearchSettings(Draw.AROUND),  # uniform, independent per axis, variance 5, Table I
    "uniform": RandomSearchSettings(Draw.UNIFORM),
    "log_uniform": RandomSearchSettings(Draw.LOG_UNIFORM),
}


class RandomSearch:
    """Independent draws after the first guess itself; scores have no influence."""

    def __init__(self, name: str, settings: RandomSearchSettings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin with the first guess."""
        self._space, self._rng = space, rng
        self._first_guess = space.clip(first_guess)
        self._asked = False

    def ask(self, n: int) -> Parameters:
        """The next n draws, shape (n, S, K)."""
        fresh = [] if self._asked else [self._first_guess]
        self._asked = True
        fresh += [self._draw() for _ in range(n - len(fresh))]
        return np.array(fresh)

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:  # noqa: ARG002  scores have no influence
        """Always False: no draw depends on an earlier one."""
        return np.zeros(len(parameters), dtype=np.bool_)

    def state(self) -> dict[str, Any]:
        """The random generator, and whether the first guess has been asked for."""
        return {"asked": self._asked, "rng": self._rng.bit_generator.state}

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`."""
        self._asked = state["asked"]
        self._rng.bit_generator.state = state["rng"]

    def _draw(self) -> Parameters:
        """One set of parameters, shape (S, K)."""
        shape = self._first_guess.shape
        if self.settings.draw is Draw.AROUND:
            half_width = math.sqrt(3 * self.settings.variance)  # of a uniform density with this variance
            return self._space.reflect(self._first_guess + self._rng.uniform(-half_width, half_width, shape))
        if self.settings.draw is Draw.UNIFORM:
            return self._space.clip(self._rng.uniform(self._space.low, self._space.high, shape))
        return np.tile(self._space.from_unit(self._rng.random(shape[1])), (shape[0], 1))
