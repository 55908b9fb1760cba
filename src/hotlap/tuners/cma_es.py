"""CMA-ES (Hansen, "The CMA evolution strategy: a tutorial", 2016) by the library `cmaes`: a baseline of Table I.

Parameters are scaled to a unit box, of logarithms or of their own units. A strategy that has converged restarts at a random mean; BIPOP
alternates large and small populations (Hansen, GECCO 2009). Warm start: WS-CMA-ES (Nomura and others, AAAI 2021).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.records import Scores
from hotlap.tuners.unit_box import UnitBox

if TYPE_CHECKING:
    from cmaes import CMA

Floats = NDArray[np.float64]

RESTART_SIGMA = 0.3
LARGE, SMALL = "large", "small"  # populations of BIPOP
WORST = 1e12  # cost of a flight whose cost is not finite


@dataclass(frozen=True)
class CmaEsSettings:
    """Settings of CMA-ES.

    Attributes:
        sigma: first standard deviation, in the unit box.
        log: whether the unit box is one of logarithms; else of the parameters' own units.
        tied: one set of parameters for all segments.
        bipop: alternate between large and small populations at restarts.
        warm: flights around the first guess from which the first distribution is estimated; 0 for none.
    """

    sigma: float = 0.15
    log: bool = True
    tied: bool = False
    bipop: bool = False
    warm: int = 0


PRESETS: Mapping[str, CmaEsSettings] = {
    "log": CmaEsSettings(),
    "raw": CmaEsSettings(log=False),
    "tied": CmaEsSettings(tied=True),
    "bipop": CmaEsSettings(bipop=True),
    "warm": CmaEsSettings(warm=12),
}


class CmaEs:
    """One generation after the other. The first guess is flown first, and is the mean of the first generation."""

    def __init__(self, name: str, settings: CmaEsSettings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin around the first guess."""
        self._rng, self._first = rng, space.clip(first_guess)
        self._box = UnitBox(space, first_guess.shape, self.settings.log, self.settings.tied)
        self._guess = self._box.encode(self._first)
        self._begin()

    def _begin(self) -> None:
        """Reset to the state before the first flight."""
        self._seed = self._rng.bit_generator.state
        self._costs: list[float] = []  # all reported costs: with the generator's first state, the whole state
        self._asked: list[Floats] = []  # points whose scores are not reported yet
        self._generation: list[tuple[Floats, float]] = []
        self._source: list[tuple[Floats, float]] = []
        self._regime, self._doublings, self._spent = LARGE, 0, {LARGE: 0, SMALL: 0}
        self._strategy: CMA | None = None if self.settings.warm else self._make(self._guess, self.settings.sigma, None)

    def ask(self, n: int) -> Parameters:
        """The rest of the generation, at most n, shape (1 to n, S, K); the first one is the first guess."""
        if not self._costs and not self._asked:
            self._asked = [self._guess]
            return self._first[None].copy()
        if not self._asked:
            self._asked = [self._draw() for _ in range(min(n, self._left()))]
        return self._box.decode(np.array(self._asked))

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Collect a generation and, when it is complete, update the distribution. True where a flight has the lowest cost so far."""
        costs = [cost if math.isfinite(cost) else WORST for cost in scores.cost.tolist()]
        better = []
        for point, cost in zip(self._asked[: len(parameters)], costs, strict=True):
            better.append(cost <= min(self._costs, default=math.inf) and cost < WORST)
            self._costs.append(cost)
            if len(self._costs) > 1:  # the first guess belongs to no generation
                self._collect(point, cost)
        self._asked = []
        return np.array(better, dtype=np.bool_)

    def state(self) -> dict[str, Any]:
        """Costs in the order reported, and the number of points under evaluation: everything else follows from the seed."""
        return {"costs": list(self._costs), "asked": len(self._asked), "rng": self._seed}

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`: draw all points again and report their costs to the strategy."""
        self._rng.bit_generator.state = state["rng"]
        self._begin()
        for k, cost in enumerate(state["costs"]):
            self._costs.append(cost)
            if k:
                self._collect(self._draw(), cost)
        if state["asked"]:
            self._asked = [self._draw() for _ in range(state["asked"])] if self._costs else [self._guess]

    def _left(self) -> int:
        """Number of points that the generation still needs."""
        if self._strategy is None:
            return self.settings.warm - len(self._source)
        return self._strategy.population_size - len(self._generation)

    def _draw(self) -> Floats:
        """A point of the generation, or one around the first guess for the warm start."""
        if self._strategy is None:
            return np.clip(self._guess + self.settings.sigma * self._rng.standard_normal(len(self._guess)), 0, 1)
        return np.asarray(self._strategy.ask(), dtype=np.float64)

    def _collect(self, point: Floats, cost: float) -> None:
        """Add a point to the generation, and update the distribution when it is complete."""
        if self._strategy is None:
            self._source.append((point, cost))
            if len(self._source) == self.settings.warm:
                from cmaes import get_warm_start_mgd  # noqa: PLC0415  it loads scipy.stats

                mean, sigma, covariance = get_warm_start_mgd(self._source, gamma=0.3, alpha=0.1)
                self._strategy = self._make(mean, sigma, covariance)
            return
        self._generation.append((point, cost))
        if len(self._generation) == self._strategy.population_size:
            self._strategy.tell(self._generation)
            self._generation = []
            if self._strategy.should_stop():
                self._restart()

    def _restart(self) -> None:
        """A new strategy at a random mean; with BIPOP, with the population size that has used fewer flights."""
        assert self._strategy is not None  # noqa: S101  it has just stopped
        ordinary = self._strategy.population_size if not self.settings.bipop else 4 + math.floor(3 * math.log(len(self._guess)))
        self._spent[self._regime] += self._strategy.population_size * self._strategy.generation
        population, sigma = ordinary, RESTART_SIGMA
        if self.settings.bipop:
            self._regime = SMALL if self._spent[SMALL] < self._spent[LARGE] else LARGE
            if self._regime == LARGE:
                self._doublings += 1
                population = ordinary * 2**self._doublings
            else:
                population = max(4, math.floor(ordinary * (2**self._doublings / 2) ** (self._rng.random() ** 2)))
                sigma = RESTART_SIGMA * 10 ** (-2 * self._rng.random())
        self._strategy = self._make(self._rng.random(len(self._guess)), sigma, None, population)

    def _make(self, mean: Floats, sigma: float, covariance: Floats | None, population: int | None = None) -> CMA:
        """A strategy within the unit box, seeded from the generator."""
        from cmaes import CMA  # noqa: PLC0415  it loads scipy.stats

        seed = int(self._rng.integers(2**31))
        box = np.tile([0.0, 1.0], (len(mean), 1))
        return CMA(np.clip(mean, 1e-9, 1 - 1e-9), sigma, bounds=box, seed=seed, population_size=population, cov=covariance)
