"""Guided walk: hotlap's own tuner, a random walk around the best point known, guided by a Gaussian process.

1. Steps are Gaussian in logarithms and the same in all segments: five numbers are found sooner than thirty-five. Only half of the
   candidates, those that move along some axes and not along others, part the segments, a little at a time.
2. Costs are dense: they tell by how much each gate was missed (`Scores.dense`), so that one flight says as much as it can.
3. After some steps, candidates around the visited point of lowest posterior mean are judged by mean - k sd; steps are of all
   sizes, and k differs from flight to flight, so that the walk neither freezes nor roams.
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

from hotlap.parameters import Parameters, ParameterSpace
from hotlap.records import Scores
from hotlap.tuners.gaussian_process import LENGTHS, Shape, choose_shape, fit

Floats = NDArray[np.float64]

POOL = 300  # candidates
REFIT = 10  # flights between looks at the likelihood
MEMORY = 200  # points that the process is fitted to
STEP_SIZES = (math.log(0.1), math.log(1.5))  # of a candidate, in units of `step`
EAGERNESS = (math.log(0.3), math.log(3.0))  # of k
ROAMING = 40  # flights, after which it roams no more
LEAP_SIZES = (0.3, 1.2)
LEAP_SHARE = 0.1  # of the points known, from which a leap may leave


@dataclass(frozen=True)
class Settings:
    """What tells one walk from another.

    Attributes:
        step: standard deviation of a step, in natural logarithms times the space's `log_step`.
        correlation: of the steps of two segments; 1 moves all alike, 0 each by itself.
        apart: whether what moves along some axes only chooses them for each segment; else for all alike.
        opening: flights around the best one, before the process guides.
        leaps: share of the flights that leave from another good point.
        roams: share of the first flights anywhere within the bounds, the same in all segments.
        dense: use the dense cost, else the metric.
    """

    step: float = 0.6
    correlation: float = 1.0
    apart: bool = True
    opening: int = 5
    leaps: float = 0.25
    roams: float = 0.2
    dense: bool = True


PRESETS: Mapping[str, Settings] = {
    "default": Settings(),
    "tied": Settings(apart=False),
    "segments": Settings(correlation=0.9),
    "independent": Settings(correlation=0.0),
    "sparse": Settings(dense=False),
    "steady": Settings(leaps=0.0, roams=0.0),
    "homely": Settings(roams=0.0),
}


class GuidedWalk:
    """A walk that remembers every flight. Each `ask` gives one proposal, the same one until it is told."""

    learns_from_any = True

    def __init__(self, name: str, settings: Settings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin at the first guess."""
        self._space, self._rng = space, rng
        self._shape_of_parameters = first_guess.shape
        self._points: list[list[float]] = []
        self._costs: list[float] = []
        self._kernel: Shape | None = None
        self._proposal: Floats | None = self._encode(space.clip(first_guess))
        self._first = space.clip(first_guess)
        count, rho = len(first_guess), self.settings.correlation
        self._factor = _factor(rho, count)

    def ask(self, n: int) -> Parameters:  # noqa: ARG002  one at a time: every flight teaches
        """The proposal, shape (1, S, K), whatever n; the first one is the first guess."""
        if not self._points:
            return self._first[None].copy()
        if self._proposal is None:
            self._proposal = self._propose()
        return self._decode(self._proposal)[None]

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Remember; true where a flight is the best so far."""
        costs = scores.dense if self.settings.dense else scores.cost
        better = []
        for flown, cost in zip(parameters, costs.tolist(), strict=True):
            known = min(self._costs, default=math.inf)
            self._points.append(self._encode(flown).tolist())
            self._costs.append(math.log1p(max(cost, 0.0)) if math.isfinite(cost) else math.inf)
            better.append(self._costs[-1] <= known)
        self._proposal = None
        return np.array(better, dtype=np.bool_)

    def state(self) -> dict[str, Any]:
        """Every flight, the kernel, a proposal under way and the random generator."""
        return {
            "points": [list(point) for point in self._points],
            "costs": [cost if math.isfinite(cost) else None for cost in self._costs],  # JSON has no infinity
            "kernel": None if self._kernel is None else [self._kernel.length, self._kernel.noise],
            "proposal": None if self._proposal is None else self._proposal.tolist(),
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go on where `state()` was taken."""
        self._points = [list(point) for point in state["points"]]
        self._costs = [math.inf if cost is None else cost for cost in state["costs"]]
        self._kernel = None if state["kernel"] is None else Shape(*state["kernel"])
        self._proposal = None if state["proposal"] is None else np.array(state["proposal"])
        self._rng.bit_generator.state = state["rng"]

    def _encode(self, parameters: Parameters) -> Floats:
        """Logarithms in units of `log_step`, all segments in a row."""
        return (np.log(parameters) / self._space.log_step).ravel()

    def _decode(self, point: Floats) -> Parameters:
        """The inverse, mirrored at the bounds."""
        logarithms = point.reshape(self._shape_of_parameters) * self._space.log_step
        return self._space.clip(np.exp(self._space.reflect_log(logarithms)))

    def _mirror(self, points: Floats) -> Floats:
        """Points, shape (count, S K), mirrored at the bounds."""
        logarithms = points.reshape(-1, *self._shape_of_parameters) * self._space.log_step
        return (self._space.reflect_log(logarithms) / self._space.log_step).reshape(points.shape)

    def _steps(self, count: int) -> Floats:
        """Gaussian steps of unit size, correlated over segments, shape (count, S K)."""
        segments, size = self._shape_of_parameters
        draws = self._rng.standard_normal((count, self._factor.shape[1], size))
        return np.einsum("st,ctk->csk", self._factor, draws).reshape(count, segments * size)

    def _propose(self) -> Floats:
        """The next point."""
        points, costs = np.array(self._points), self._finite_costs()
        if self._rng.random() < self.settings.roams and len(costs) < ROAMING:
            return self._anywhere()
        if len(costs) <= self.settings.opening:
            return points[int(np.argmin(costs))] + self.settings.step * self._steps(1)[0]
        chosen = self._remembered(costs)
        points, costs = points[chosen], costs[chosen]
        if self._kernel is None or len(self._costs) % REFIT == 0:
            lengths = tuple(length * math.sqrt(self._shape_of_parameters[0]) for length in LENGTHS)
            self._kernel = choose_shape(points, costs, lengths)
        posterior = fit(points, costs, self._kernel)
        means = posterior.predict(points)[0]
        if self._rng.random() < self.settings.leaps:
            good = np.argsort(means)[: max(3, round(LEAP_SHARE * len(means)))]
            size = self.settings.step * self._rng.uniform(*LEAP_SIZES)
            return points[int(self._rng.choice(good))] + size * self._steps(1)[0]
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

    def _anywhere(self) -> Floats:
        """A point drawn evenly from the logarithms within the bounds, the same in all segments."""
        segments, size = self._shape_of_parameters
        return np.tile(np.log(self._space.from_unit(self._rng.random(size))) / self._space.log_step, segments)

    def _finite_costs(self) -> Floats:
        """Costs, with what is infinite a little worse than the worst."""
        costs = np.array(self._costs)
        finite = costs[np.isfinite(costs)]
        worst = float(finite.max()) + 1.0 if len(finite) else 0.0
        return np.where(np.isfinite(costs), costs, worst)

    def _remembered(self, costs: Floats) -> NDArray[np.intp]:
        """The points that are fitted: all, or the best and the latest half of `MEMORY`."""
        if len(costs) <= MEMORY:
            return np.arange(len(costs))
        best = np.argsort(costs, kind="stable")[: MEMORY // 2]
        return np.union1d(best, np.arange(len(costs) - MEMORY // 2, len(costs)))


def _factor(correlation: float, count: int) -> Floats:
    """L with L L' = 1 on the diagonal and the correlation elsewhere, shape (count, count), or (count, 1) where all move alike."""
    if correlation == 1.0:
        return np.ones((count, 1))
    return np.asarray(np.linalg.cholesky((1 - correlation) * np.eye(count) + correlation), dtype=np.float64)
