"""Walk: base class of the tuners that keep all flights and propose steps from the best point by a surrogate model of the cost."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores
from hotlap.tuners.surrogates.threads import one_thread

Floats = NDArray[np.float64]

MEMORY = 200  # points that the surrogate model is fitted to
RESTART_SIZES = (0.3, 1.2)  # range of the standard deviation of the first step after a restart, in units of `step`
RESTART_SHARE = 0.1  # share of the points, the best ones, from which a restart may begin


@dataclass(frozen=True)
class WalkSettings:
    """Settings of every walk.

    Attributes:
        step: standard deviation of a step, in natural logarithms times the space's `log_step`.
        opening: number of flights before the surrogate model is used; they are Gaussian steps from the point of lowest cost.
        restart_probability: probability that a proposal is a step from another one of the best points.
        exploration: probability, at the beginning, that a proposal is drawn uniformly within the bounds, in logarithms, the same in all
            segments.
        dense: use the dense cost, for which a flight continues after a missed gate; else the metric.
    """

    step: float = 0.6
    opening: int = 5
    restart_probability: float = 0.25
    exploration: float = 0.2
    dense: bool = True


AnySettings = TypeVar("AnySettings", bound=WalkSettings)


class Walk(ABC, Generic[AnySettings]):
    """A walk that keeps all flights. Each `ask` gives one proposal, the same one until its score is reported."""

    learns_from_any: ClassVar[bool] = True

    def __init__(self, name: str, settings: AnySettings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin at the first guess."""
        self._space, self._rng = space, rng
        self._shape_of_parameters = first_guess.shape
        self._points: list[list[float]] = []
        self._costs: list[float] = []
        self._first = space.clip(first_guess)
        self._proposal: Floats | None = self._encode(self._first)

    def ask(self, n: int) -> Parameters:  # noqa: ARG002  one at a time: the next proposal depends on every score
        """The proposal, shape (1, S, K), whatever n; the first one is the first guess."""
        if not self._points:
            return self._first[None].copy()
        if self._proposal is None:
            with one_thread():
                self._proposal = self._next()
        return self._decode(self._proposal)[None]

    def ask_together(self, n: int) -> Parameters:
        """Proposals of one model, shape (n, S, K); at the beginning the first guess and steps from it."""
        first = [self.ask(1)[0]]
        if not self._points:
            steps = self.settings.step * self._steps(n - 1)
            return np.array(first + [self._decode(self._encode(self._first) + step) for step in steps])
        with one_thread():
            return np.array(first + [self._decode(self._next()) for _ in range(n - 1)])

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Store points and costs; True where a flight has the lowest cost so far."""
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
        """All flights, the current proposal and the random generator."""
        return {
            "points": list(self._points),  # no point is written into
            "costs": [cost if math.isfinite(cost) else None for cost in self._costs],  # JSON has no infinity
            "proposal": None if self._proposal is None else self._proposal.tolist(),
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`."""
        self._points = [list(point) for point in state["points"]]
        self._costs = [math.inf if cost is None else cost for cost in state["costs"]]
        self._proposal = None if state["proposal"] is None else np.array(state["proposal"])
        self._rng.bit_generator.state = state["rng"]

    @abstractmethod
    def _propose(self, costs: Floats) -> Floats:
        """The next point after the opening, shape (S K,), given finite costs of all points."""

    @abstractmethod
    def _steps(self, count: int) -> Floats:
        """Gaussian steps of unit size, shape (count, S K)."""

    def _next(self) -> Floats:
        """The next point: uniformly drawn, a step from the best point, or by the surrogate model."""
        costs = self._finite_costs()
        if self._rng.random() < self._exploration_probability(len(costs)):
            return self._draw_uniformly()
        if len(costs) <= self.settings.opening:
            return np.array(self._points[int(np.argmin(costs))]) + self.settings.step * self._steps(1)[0]
        return self._propose(costs)

    def _restart(self, good: Floats) -> Floats:
        """A step from a random one of some points, shape (count, S K)."""
        size = self.settings.step * self._rng.uniform(*RESTART_SIZES)
        return good[int(self._rng.integers(len(good)))] + size * self._steps(1)[0]

    @abstractmethod
    def _exploration_probability(self, flown: int) -> float:
        """Probability, after so many flights, that the next proposal is drawn uniformly within the bounds."""

    def _encode(self, parameters: Parameters) -> Floats:
        """Logarithms of parameters of shape (S, K) in units of `log_step`, shape (S K,)."""
        return (np.log(parameters) / self._space.log_step).ravel()

    def _decode(self, point: Floats) -> Parameters:
        """Parameters, shape (S, K), at a point, mirrored at the bounds."""
        logarithms = point.reshape(self._shape_of_parameters) * self._space.log_step
        return self._space.clip(np.exp(self._space.reflect_log(logarithms)))

    def _mirror(self, points: Floats) -> Floats:
        """Points, shape (count, S K), mirrored at the bounds."""
        logarithms = points.reshape(-1, *self._shape_of_parameters) * self._space.log_step
        return (self._space.reflect_log(logarithms) / self._space.log_step).reshape(points.shape)

    def _draw_uniformly(self) -> Floats:
        """A point drawn uniformly from the logarithms within the bounds, the same in all segments."""
        segments, size = self._shape_of_parameters
        return np.tile(np.log(self._space.from_unit(self._rng.random(size))) / self._space.log_step, segments)

    def _finite_costs(self) -> Floats:
        """Costs of all flights, shape (n,); an infinite cost is replaced by the largest finite one plus 1."""
        costs = np.array(self._costs)
        finite = costs[np.isfinite(costs)]
        worst = float(finite.max()) + 1.0 if len(finite) else 0.0
        return np.where(np.isfinite(costs), costs, worst)


def restart_points(values: Floats) -> NDArray[np.intp]:
    """Indices of the best points, from which a restart may begin.

    Args:
        values: predicted costs of all points, shape (n,).
    """
    return np.argsort(values)[: max(3, round(RESTART_SHARE * len(values)))]


def fitted(costs: Floats) -> NDArray[np.intp]:
    """Indices of the points that the surrogate model is fitted to: at most `MEMORY`, half of them the best ones, half the latest.

    Args:
        costs: of all points, shape (n,).
    """
    if len(costs) <= MEMORY:
        return np.arange(len(costs))
    best = np.argsort(costs, kind="stable")[: MEMORY // 2]
    return np.union1d(best, np.arange(len(costs) - MEMORY // 2, len(costs)))
