"""Guided walk: hotlap's own tuner where there are no gates, a random walk around the best point known, guided by a Gaussian process.

1. Steps are Gaussian in logarithms and the same in all segments: five numbers are found sooner than thirty-five. Only half of the
   candidates, those that move along some axes and not along others, part the segments, a little at a time.
2. Costs are dense: they tell by how much each gate was missed (`Scores.dense`), so that one flight says as much as it can.
3. After some steps, candidates around the visited point of lowest posterior mean are judged by mean - k sd; steps are of all
   sizes, and k differs from flight to flight, so that the walk neither freezes nor exploration.
4. With a small probability it leaves from another good point, or at first flies anywhere: chance, against being caught in one place, and
   because the first guess may be far from everything that flies.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.tuners.surrogates.gaussian_process import Kernel, likeliest_of
from hotlap.tuners.walk import Walk, WalkSettings, fitted, leaping_points

Floats = NDArray[np.float64]

ROAMING = 40  # flights, after which it exploration no more
POOL = 300  # candidates
LENGTHS = (0.7, 1.5, 3.0, 6.0)  # grid of the length scale, times the square root of the number of segments
NOISES = (0.02, 0.1, 0.3, 0.8)  # grid of the noise's variance over the signal's
REFIT = 10  # flights between looks at the likelihood
STEP_SIZES = (math.log(0.1), math.log(1.5))  # of a candidate, in units of `step`
EAGERNESS = (math.log(0.3), math.log(3.0))  # of k


@dataclass(frozen=True)
class GuidedWalkSettings(WalkSettings):
    """What tells one guided walk from another.

    Attributes:
        correlation: of the steps of two segments; 1 moves all alike, 0 each by itself.
        apart: whether what moves along some axes only chooses them for each segment; else for all alike.
    """

    correlation: float = 1.0
    apart: bool = True


PRESETS: Mapping[str, GuidedWalkSettings] = {
    "default": GuidedWalkSettings(),
    "tied": GuidedWalkSettings(apart=False),
    "segments": GuidedWalkSettings(correlation=0.9),
    "independent": GuidedWalkSettings(correlation=0.0),
    "sparse": GuidedWalkSettings(dense=False),
    "no_restarts": GuidedWalkSettings(restart_probability=0.0, exploration=0.0),
    "no_exploration": GuidedWalkSettings(exploration=0.0),
}


class GuidedWalk(Walk[GuidedWalkSettings]):
    """A walk guided by one process for the cost."""

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin at the first guess."""
        super().start(first_guess, space, rng)
        self._kernel: Kernel | None = None
        self._factor = _factor(self.settings.correlation, len(first_guess))

    def state(self) -> dict[str, Any]:
        """Every flight, the kernel, a proposal under way and the random generator."""
        return {**super().state(), "kernel": None if self._kernel is None else [self._kernel.lengths, self._kernel.noise]}

    def restore(self, state: dict[str, Any]) -> None:
        """Go on where `state()` was taken."""
        super().restore(state)
        self._kernel = None if state["kernel"] is None else Kernel(*state["kernel"])

    def _roaming(self, flown: int) -> float:
        """Chance of a flight anywhere after so many."""
        return self.settings.exploration if flown < ROAMING else 0.0

    def _steps(self, count: int) -> Floats:
        """Gaussian steps of unit size, correlated over segments, shape (count, S K)."""
        segments, size = self._shape_of_parameters
        draws = self._rng.standard_normal((count, self._factor.shape[1], size))
        return np.einsum("st,ctk->csk", self._factor, draws).reshape(count, segments * size)

    def _propose(self, costs: Floats) -> Floats:
        """The lowest of many candidates, or a leap."""
        chosen = fitted(costs)
        points, costs = np.array(self._points)[chosen], costs[chosen]
        if self._kernel is None or len(self._costs) % REFIT == 0:
            lengths = [length * math.sqrt(self._shape_of_parameters[0]) for length in LENGTHS]
            self._kernel = likeliest_of(points, costs, lengths, NOISES)
        posterior = self._kernel.condition(points, costs)
        means = posterior.predict(points)[0]
        if self._rng.random() < self.settings.restart_probability:
            return self._leap(points[leaping_points(means)])
        sizes = self.settings.step * np.exp(self._rng.uniform(*STEP_SIZES, (POOL, 1)))
        steps = sizes * self._steps(POOL)
        steps[POOL // 2 :] *= self._some_axes(POOL - POOL // 2)
        pool = self._mirror(points[int(np.argmin(means))] + steps)
        mean, deviation = posterior.predict(pool)
        k = math.exp(self._rng.uniform(*EAGERNESS))
        return pool[int(np.argmin(mean - k * deviation))]

    def _some_axes(self, count: int) -> NDArray[np.bool_]:
        """Half of the axes, by chance, shape (count, S K)."""
        segments, size = self._shape_of_parameters
        if self.settings.apart:
            return self._rng.random((count, segments * size)) < 0.5
        return np.tile(self._rng.random((count, size)) < 0.5, (1, segments))


def _factor(correlation: float, count: int) -> Floats:
    """L with L L' = 1 on the diagonal and the correlation elsewhere, shape (count, count), or (count, 1) where all move alike."""
    if correlation == 1.0:
        return np.ones((count, 1))
    return np.asarray(np.linalg.cholesky((1 - correlation) * np.eye(count) + correlation), dtype=np.float64)
