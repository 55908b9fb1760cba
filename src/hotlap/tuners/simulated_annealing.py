"""Simulated annealing: the sampler with a temperature that decreases from flight to flight (Kirkpatrick and others, Science 1983).

The paper notes that its sampler is annealing at constant temperature, and claims that cooling needs many more samples (Sec. IV-A).
"""

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
from hotlap.tuners.metropolis_hastings import MetropolisHastings, MetropolisHastingsSettings, Scale


class Cooling(StrEnum):
    """How the temperature decreases: by a constant factor, or as slowly as convergence in probability needs."""

    GEOMETRIC = "geometric"
    LOGARITHMIC = "logarithmic"


@dataclass(frozen=True)
class SimulatedAnnealingSettings:
    """Settings of simulated annealing.

    Attributes:
        walk: settings of the sampler; its temperature is that of the first decision.
        cooling: how the temperature decreases.
        factor: ratio of the temperatures of consecutive flights, for GEOMETRIC.
        coldest: lowest temperature.
    """

    walk: MetropolisHastingsSettings
    cooling: Cooling = Cooling.GEOMETRIC
    factor: float = 0.95
    coldest: float = 0.1

    def temperature(self, decisions: int) -> float:
        """Temperature of a decision, given the number of decisions before it; it does not depend on the budget, which is not known."""
        shares = {
            Cooling.GEOMETRIC: self.factor**decisions,  # T_k = a^k T_0, Kirkpatrick and others
            Cooling.LOGARITHMIC: math.log(2.0) / math.log(2.0 + decisions),  # T_k = c / log(k), Geman, Geman, PAMI 1984
        }
        return max(self.walk.temperature * shares[self.cooling], self.coldest)


HOT = 30.0  # [s] of cost: a few missed gates
_TIED = MetropolisHastingsSettings(0.3, Scale.LOG, tied=1.0, temperature=HOT)
_PAPER = MetropolisHastingsSettings(5.0, Scale.RAW, tied=0.0, temperature=HOT)

PRESETS: Mapping[str, SimulatedAnnealingSettings] = {
    "tied": SimulatedAnnealingSettings(_TIED),
    "slow": SimulatedAnnealingSettings(_TIED, factor=0.99),
    "logarithmic": SimulatedAnnealingSettings(_TIED, Cooling.LOGARITHMIC),
    "paper": SimulatedAnnealingSettings(_PAPER),  # the paper's steps, cooled
}


class SimulatedAnnealing:
    """A chain of `MetropolisHastings` whose temperature is set before each decision."""

    def __init__(self, name: str, settings: SimulatedAnnealingSettings) -> None:
        self.name, self.settings = name, settings
        self._chain = MetropolisHastings(name, settings.walk)

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin at the first guess, at the first temperature."""
        self._chain.start(first_guess, space, rng)
        self._flown = 0

    def ask(self, n: int) -> Parameters:
        """The proposal, shape (1, S, K), whatever n; the first one is the first guess."""
        return self._chain.ask(n)

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Accept the proposal, or keep the current sample; then lower the temperature."""
        self._chain.temperature = self.settings.temperature(max(self._flown - 1, 0))  # the first guess is accepted without a decision
        self._flown += len(parameters)
        return self._chain.tell(parameters, scores)

    def state(self) -> dict[str, Any]:
        """State of the chain, and the number of flights."""
        return {"flown": self._flown, "chain": self._chain.state()}

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`."""
        self._flown = state["flown"]
        self._chain.restore(state["chain"])
