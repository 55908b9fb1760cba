"""Bayesian optimisation with Gaussian processes (Jones, Schonlau, Welch, J. Global Optimization 13, 1998): a baseline of Table I.

A Gaussian process of scikit-learn predicts the cost from the parameters of all segments, scaled to a unit box. The paper names its five
kernels only; everything else follows common practice: constant mean, one length scale for all axes, signal, length scale and noise by
maximum marginal likelihood, standardised costs, expected improvement (EI), ten first flights of a Latin hypercube (as in scikit-optimize).
The cost is noisy, so the improvement is over the lowest posterior mean at a flown point, not over the lowest cost (EI with "plug-in":
Picheny, Wagner, Ginsbourger, Struct. Multidisc. Optim. 48, 2013).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores
from hotlap.tuners.surrogates.threads import one_thread
from hotlap.tuners.unit_box import UnitBox, latin_hypercube

Floats = NDArray[np.float64]

WORST = 1e12  # limit of a cost, of either sign
REFIT = 10  # flights between updates of the hyperparameters
MEMORY = 200  # points that the process is fitted to
POOL = 300  # candidates
STEP_SIZES = (math.log(0.01), math.log(0.3))  # range of the logarithm of steps from the best point, in the unit box
LOCAL_STEPS = (0.1, 0.03, 0.01)  # standard deviations of the local search, one after the other, in the unit box
NEIGHBOURS = 40  # candidates of each of these


class Family(StrEnum):
    """Kernels of Table I, named as in `kernels.KERNELS`."""

    MATERN = "matern"
    LOCALLY_PERIODIC = "locally_periodic"
    RATIONAL_QUADRATIC = "rational_quadratic"
    SQUARED_EXPONENTIAL = "squared_exponential"
    PERIODIC = "periodic"


@dataclass(frozen=True)
class BayesianSettings:
    """Settings of Bayesian optimisation.

    Attributes:
        family: covariance function.
        log: whether the unit box is one of logarithms; else of the parameters' own units.
        opening: flights before the process is used: the first guess, and a Latin hypercube.
    """

    family: Family = Family.MATERN
    log: bool = False
    opening: int = 10


PRESETS: Mapping[str, BayesianSettings] = {
    "matern": BayesianSettings(),
    "locally_periodic": BayesianSettings(Family.LOCALLY_PERIODIC),
    "rational_quadratic": BayesianSettings(Family.RATIONAL_QUADRATIC),
    "squared_exponential": BayesianSettings(Family.SQUARED_EXPONENTIAL),
    "periodic": BayesianSettings(Family.PERIODIC),
    "log": BayesianSettings(log=True),
}


class Bayesian:
    """The opening can be asked for in batches; then each `ask` gives one proposal, the same one until its score is reported."""

    def __init__(self, name: str, settings: BayesianSettings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Choose the points of the opening."""
        self._rng, self._box = rng, UnitBox(space, first_guess.shape, self.settings.log)
        self._first = space.clip(first_guess)
        self._points: list[list[float]] = []
        self._costs: list[float] = []
        self._theta: list[float] | None = None  # logarithms of the hyperparameters
        hypercube = latin_hypercube(self.settings.opening - 1, first_guess.size, rng)
        self._queue: list[list[float]] = [self._box.encode(self._first).tolist(), *hypercube.tolist()]

    def ask(self, n: int) -> Parameters:
        """The rest of the opening, at most n, then one proposal, shape (1 to n, S, K); the first one is the first guess."""
        if not self._queue:
            self._queue = [self._propose().tolist()]
        asked = self._box.decode(np.array(self._queue[:n]))
        if not self._points:
            asked[0] = self._first  # without the rounding of the unit box
        return asked

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Store points and costs; True where a flight has the lowest cost so far."""
        better = []
        for cost in scores.cost.tolist():
            known = min(self._costs, default=math.inf)
            self._costs.append(min(max(cost, -WORST), WORST) if math.isfinite(cost) else math.inf)
            better.append(self._costs[-1] <= known and math.isfinite(cost))
        self._points += self._queue[: len(parameters)]
        self._queue = self._queue[len(parameters) :]
        return np.array(better, dtype=np.bool_)

    def state(self) -> dict[str, Any]:
        """All flights, the hyperparameters, the points to be flown next and the random generator."""
        return {
            "points": [list(point) for point in self._points],
            "costs": [cost if math.isfinite(cost) else None for cost in self._costs],  # JSON has no infinity
            "theta": None if self._theta is None else list(self._theta),
            "queue": [list(point) for point in self._queue],
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`."""
        self._points = [list(point) for point in state["points"]]
        self._costs = [math.inf if cost is None else cost for cost in state["costs"]]
        self._theta = None if state["theta"] is None else list(state["theta"])
        self._queue = [list(point) for point in state["queue"]]
        self._rng.bit_generator.state = state["rng"]

    def _propose(self) -> Floats:
        """The point of largest expected improvement found by random and local search, shape (S K,)."""
        from hotlap.tuners.surrogates import kernels  # noqa: PLC0415  it loads scikit-learn

        costs = np.array(self._costs)
        chosen = remembered(costs)
        points, values = np.array(self._points)[chosen], standardise(costs[chosen])
        covariance = kernels.covariance_of(self.settings.family.value)
        with one_thread():
            if self._theta is None or len(self._costs) % REFIT == 0:
                self._theta = kernels.likeliest(covariance, points, values, self._theta)
            process = kernels.condition(covariance, points, values, self._theta)
            means = process.predict(points)

            def merit(candidates: Floats) -> Floats:
                mean, deviation = process.predict(candidates, return_std=True)
                return log_expected_improvement(mean, deviation, float(means.min()))

            return self._climb(merit, self._pool(points[int(means.argmin())]))

    def _climb(self, merit: Callable[[Floats], Floats], candidates: Floats) -> Floats:
        """The best of some candidates, shape (count, S K), improved by a local search with smaller and smaller steps; shape (S K,)."""
        for step in LOCAL_STEPS:
            best = candidates[int(merit(candidates).argmax())]
            candidates = np.vstack([best, self._around(best, np.full((NEIGHBOURS, 1), step))])
        return candidates[int(merit(candidates).argmax())]

    def _pool(self, best: Floats) -> Floats:
        """Candidates, shape (POOL, S K): half of them uniform in the box, half of them around the best point."""
        sizes = np.exp(self._rng.uniform(*STEP_SIZES, (POOL // 2, 1)))
        return np.vstack([self._rng.random((POOL // 2, len(best))), self._around(best, sizes)])

    def _around(self, centre: Floats, sizes: Floats) -> Floats:
        """Gaussian steps of sizes of shape (count, 1), clipped at the box; every second one along a random half of the axes."""
        steps = sizes * self._rng.standard_normal((len(sizes), len(centre)))
        steps[::2] *= self._rng.random(steps[::2].shape) < 0.5
        return np.clip(centre + steps, 0, 1)


def standardise(costs: Floats) -> Floats:
    """Costs with mean 0 and variance 1, shape (n,); infinite ones are first replaced by the largest plus a tenth of the deviation."""
    finite = costs[np.isfinite(costs)]
    worst = finite.max() + 0.1 * finite.std() if len(finite) else 0.0
    full = np.where(np.isfinite(costs), costs, worst)
    return (full - full.mean()) / max(full.std(), 1e-9 * max(1.0, abs(full.mean())))


def remembered(costs: Floats) -> NDArray[np.intp]:
    """Indices of the points that the process is fitted to: at most `MEMORY`, half of them the best ones, half the latest."""
    if len(costs) <= MEMORY:
        return np.arange(len(costs))
    best = np.argsort(costs, kind="stable")[: MEMORY // 2]
    return np.union1d(best, np.arange(len(costs) - MEMORY // 2, len(costs)))


def log_expected_improvement(mean: Floats, deviation: Floats, incumbent: float) -> Floats:
    """log of E[max(incumbent - y, 0)], y ~ N(mean, deviation^2), shape (n,).

    EI = deviation (phi(z) + z Phi(z)), z = (incumbent - mean) / deviation (Jones and others, 1998, Eq. 15); as a logarithm, far
    below the incumbent too, where EI underflows (Ament and others, NeurIPS 2023).
    """
    from scipy.special import erfcx, ndtr  # noqa: PLC0415  as above

    deviation = np.maximum(deviation, 1e-12)
    z = (incumbent - mean) / deviation
    near, far = np.maximum(z, -1.0), np.clip(z, -1e4, -1.0)
    above = np.log(np.exp(-0.5 * near**2) / math.sqrt(2 * math.pi) + near * ndtr(near))
    ratio = np.log1p(far * math.sqrt(math.pi / 2) * erfcx(-far / math.sqrt(2)))  # log(1 + z Phi(z) / phi(z))
    below = -0.5 * z**2 - 0.5 * math.log(2 * math.pi) + ratio
    return np.log(deviation) + np.where(z > -1, above, below)
