"""Guided walk: random steps from the best point, selected by a Gaussian process of the cost; the tuner for costs that have no gates.

1. Steps are Gaussian in the logarithms of the parameters and, by default, the same in all segments: a search over K parameters needs fewer
   flights than one over S K. Half of the candidates move a random half of the axes only, which lets the segments differ.
2. The cost is the dense one, a sum over all gates of how far each is missed (`Scores.dense`): one flight gives more information.
3. After the opening, candidates around the flown point of lowest posterior mean are ranked by the lower confidence bound, mean - k sd.
   Step sizes and k are drawn anew for each flight, which mixes exploitation and exploration.
4. With `restart_probability` a proposal is a step from another good point; with the probability `exploration`, in the first flights, it is
   drawn uniformly within the bounds. Both keep the search out of local minima and help where the first guess crashes.
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
from hotlap.tuners.walk import Walk, WalkSettings, fitted, restart_points

Floats = NDArray[np.float64]

EXPLORED = 40  # flights after which no proposal is drawn uniformly
POOL = 300  # candidates of a proposal
LENGTHS = (0.7, 1.5, 3.0, 6.0)  # grid of the length scale, times the square root of the number of segments
NOISES = (0.02, 0.1, 0.3, 0.8)  # grid of the noise's variance over the signal's
REFIT = 10  # flights between selections of the kernel
STEP_SIZES = (math.log(0.1), math.log(1.5))  # range of the logarithm of a candidate's step size, in units of `step`
CONFIDENCE = (math.log(0.3), math.log(3.0))  # range of log k of the lower confidence bound


@dataclass(frozen=True)
class GuidedWalkSettings(WalkSettings):
    """Settings of the guided walk.

    Attributes:
        correlation: correlation coefficient of the steps of two segments; 1: the same step in all segments, 0: independent steps.
        apart: whether candidates that move some axes only draw these axes for each segment; else the same axes in all segments.
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
    """A random walk guided by one Gaussian process of the cost."""

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin at the first guess."""
        super().start(first_guess, space, rng)
        self._kernel: Kernel | None = None
        self._factor = _factor(self.settings.correlation, len(first_guess))

    def state(self) -> dict[str, Any]:
        """All flights, the kernel, the current proposal and the random generator."""
        return {**super().state(), "kernel": None if self._kernel is None else [self._kernel.lengths, self._kernel.noise]}

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`."""
        super().restore(state)
        self._kernel = None if state["kernel"] is None else Kernel(*state["kernel"])

    def _exploration_probability(self, flown: int) -> float:
        """Probability of a uniformly drawn proposal: `exploration` in the first `EXPLORED` flights, then 0."""
        return self.settings.exploration if flown < EXPLORED else 0.0

    def _steps(self, count: int) -> Floats:
        """Gaussian steps of unit size, correlated over segments, shape (count, S K)."""
        segments, size = self._shape_of_parameters
        draws = self._rng.standard_normal((count, self._factor.shape[1], size))
        return np.einsum("st,ctk->csk", self._factor, draws).reshape(count, segments * size)

    def _propose(self, costs: Floats) -> Floats:
        """The candidate of lowest confidence bound, or a restart; shape (S K,)."""
        chosen = fitted(costs)
        points, costs = np.array(self._points)[chosen], costs[chosen]
        if self._kernel is None or len(self._costs) % REFIT == 0:
            lengths = [length * math.sqrt(self._shape_of_parameters[0]) for length in LENGTHS]
            self._kernel = likeliest_of(points, costs, lengths, NOISES)
        posterior = self._kernel.condition(points, costs)
        means = posterior.predict(points)[0]
        if self._rng.random() < self.settings.restart_probability:
            return self._restart(points[restart_points(means)])
        sizes = self.settings.step * np.exp(self._rng.uniform(*STEP_SIZES, (POOL, 1)))
        steps = sizes * self._steps(POOL)
        steps[POOL // 2 :] *= self._some_axes(POOL - POOL // 2)
        pool = self._mirror(points[int(np.argmin(means))] + steps)
        mean, deviation = posterior.predict(pool)
        k = math.exp(self._rng.uniform(*CONFIDENCE))
        return pool[int(np.argmin(mean - k * deviation))]

    def _some_axes(self, count: int) -> NDArray[np.bool_]:
        """Each axis with probability 1/2, shape (count, S K)."""
        segments, size = self._shape_of_parameters
        if self.settings.apart:
            return self._rng.random((count, segments * size)) < 0.5
        return np.tile(self._rng.random((count, size)) < 0.5, (1, segments))


def _factor(correlation: float, count: int) -> Floats:
    """L with L L' = 1 on the diagonal and the correlation elsewhere, shape (count, count), or (count, 1) where all move alike."""
    if correlation == 1.0:
        return np.ones((count, 1))
    return np.asarray(np.linalg.cholesky((1 - correlation) * np.eye(count) + correlation), dtype=np.float64)
