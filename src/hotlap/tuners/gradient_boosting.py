"""Gradient boosting: boosted regression trees (Friedman, 2001) predict the cost, and the lowest prediction is flown.

A baseline of Table I, which the paper does not describe. Here the trees are a surrogate model of the cost that is fitted again after every
`REFIT` flights, with the default settings of scikit-learn, as for the paper's regressor. Trees give no uncertainty, so a share of the
flights explores at random.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace, reflect
from hotlap.core.records import Scores

if TYPE_CHECKING:
    from sklearn.ensemble import GradientBoostingRegressor

Floats = NDArray[np.float64]

INITIAL = 10  # flights before the trees are used
REFIT = 10  # flights between fits
POOL = 1000  # candidates
WORST = 1e12  # limit of a cost, of either sign


@dataclass(frozen=True)
class GradientBoostingSettings:
    """Settings of gradient boosting.

    Attributes:
        exploration: probability that a random candidate is flown instead of the best one, once the trees are used.
        spread: standard deviation of candidates around the best point, as a share of the range of each axis.
        near: share of the candidates that lie around the best point; the others are uniform within the bounds.
        log: draw candidates in logarithms; else in the parameters' own units.
    """

    exploration: float = 0.1
    spread: float = 0.1
    near: float = 0.5
    log: bool = False


PRESETS: Mapping[str, GradientBoostingSettings] = {"surrogate": GradientBoostingSettings(), "log": GradientBoostingSettings(log=True)}


class GradientBoosting:
    """All flights are kept. An ask gives points chosen by the latest fit, the same until their scores are reported."""

    def __init__(self, name: str, settings: GradientBoostingSettings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin at the first guess."""
        self._space, self._rng, self._shape = space, rng, first_guess.shape
        self._waiting: Parameters = space.clip(first_guess)[None].copy()
        self._flown, self._costs = np.empty((0, *first_guess.shape)), np.empty(0)
        self._seed = int(rng.integers(2**31))
        self._trees: GradientBoostingRegressor | None = None
        self._fitted = 0

    def ask(self, n: int) -> Parameters:
        """At most n points that are to be flown, shape (1 to n, S, K); the first one is the first guess."""
        if not len(self._waiting):
            self._waiting = np.array([self._choose() for _ in range(min(n, REFIT - len(self._costs) % REFIT))])
        return self._waiting[:n].copy()

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Store points and costs; True where a flight has the lowest cost so far."""
        costs = np.nan_to_num(np.clip(scores.cost, -WORST, WORST), nan=WORST)
        known = np.minimum.accumulate(np.append(self._costs.min(initial=np.inf), costs))
        reported, self._waiting = self._waiting[: len(parameters)], self._waiting[len(parameters) :]
        self._flown, self._costs = np.concatenate([self._flown, reported]), np.append(self._costs, costs)
        return np.asarray((costs <= known[:-1]) & (costs < WORST), dtype=np.bool_)

    def state(self) -> dict[str, Any]:
        """All flights, the points to be flown, the seed of the trees and the random generator."""
        flights = {"flown": self._flown.tolist(), "costs": self._costs.tolist(), "waiting": self._waiting.tolist()}
        return {**flights, "seed": self._seed, "rng": self._rng.bit_generator.state}

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`; the trees are fitted again to the same flights."""
        self._flown, self._waiting = (np.array(state[name], dtype=np.float64).reshape(-1, *self._shape) for name in ("flown", "waiting"))
        self._costs, self._seed = np.array(state["costs"], dtype=np.float64), state["seed"]
        self._trees, self._fitted = None, 0
        self._rng.bit_generator.state = state["rng"]

    def _choose(self) -> Parameters:
        """The candidate of lowest predicted cost, or a random one, shape (S, K)."""
        candidates, explores = self._candidates(), self._rng.random() < self.settings.exploration
        if explores or len(self._costs) < INITIAL:
            return candidates[int(self._rng.integers(POOL))]
        return candidates[int(np.argmin(self._fit().predict(candidates.reshape(POOL, -1))))]

    def _candidates(self) -> Parameters:
        """Points around the best one and points uniform within the bounds, in random order, shape (`POOL`, S, K)."""
        low, high = self._scale(self._space.low), self._scale(self._space.high)
        shape = (POOL, *self._shape)
        points = self._rng.uniform(low, high, shape)
        if len(self._costs):
            best = self._scale(self._flown[int(np.argmin(self._costs))])
            around = reflect(best + self.settings.spread * (high - low) * self._rng.standard_normal(shape), low, high)
            near = self._rng.random(POOL) < self.settings.near
            points = np.where(near[:, None, None], around, points)
        return self._space.clip(np.exp(points) if self.settings.log else points)

    def _scale(self, parameters: Parameters) -> Floats:
        """Parameters in the scale in which they are drawn, any shape."""
        return np.log(parameters) if self.settings.log else parameters

    def _fit(self) -> GradientBoostingRegressor:
        """Trees fitted to the first flights, a multiple of `REFIT`, so that predictions do not depend on the batches that are asked for."""
        count = len(self._costs) // REFIT * REFIT
        if self._trees is None or self._fitted != count:
            from sklearn.ensemble import GradientBoostingRegressor  # noqa: PLC0415  it takes a second to load

            trees = GradientBoostingRegressor(random_state=self._seed)
            self._trees, self._fitted = trees.fit(self._flown[:count].reshape(count, -1), _tame(self._costs[:count])), count
        return self._trees


def _tame(costs: Floats) -> Floats:
    """Costs, shape (n,), with those at `WORST` lowered to one standard deviation above the largest other."""
    proper = costs[costs < WORST]
    return np.minimum(costs, proper.max() + (proper.std() or 1.0)) if len(proper) else costs
