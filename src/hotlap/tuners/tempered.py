"""Parallel tempering, chains at several temperatures that swap samples, and multiple-try Metropolis, several proposals for each step.

Parallel tempering: Geyer, "Markov chain Monte Carlo maximum likelihood", 1991. Multiple-try Metropolis: Liu, Liang, Wong, JASA 2000.
The preset `independent` is the control: as many chains, all at temperature 1, without swaps, in the same number of flights.
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
from hotlap.tuners import metropolis_hastings
from hotlap.tuners.metropolis_hastings import MetropolisHastingsSettings, negative_log_score, propose

Floats = NDArray[np.float64]

WORST = 1e200  # cost of a flight without a finite cost, so that its logarithmic score is finite too


class Phase(StrEnum):
    """What is being flown: the first guess, proposals of all chains, or the reference points around the chosen proposals."""

    FIRST = "first"
    TRIES = "tries"
    REFERENCES = "references"


@dataclass(frozen=True)
class TemperedSettings:
    """Settings of the chains.

    Attributes:
        walk: settings of the sampler, for every chain; its temperature is not used.
        temperatures: temperature of each chain, in increasing order.
        swaps: whether chains of neighbouring temperatures may exchange their samples after every step.
        tries: proposals for each step of a chain; more than one need `tries - 1` further flights, of reference points.
    """

    walk: MetropolisHastingsSettings
    temperatures: tuple[float, ...] = (1.0,)
    swaps: bool = False
    tries: int = 1


_TIED = metropolis_hastings.PRESETS["tied"]

PRESETS: Mapping[str, TemperedSettings] = {
    "swapping": TemperedSettings(_TIED, (1.0, 4.0, 16.0, 64.0), swaps=True),
    "independent": TemperedSettings(_TIED, (1.0, 1.0, 1.0, 1.0)),
    "multiple_try": TemperedSettings(_TIED, tries=3),
    "swapping_paper": TemperedSettings(metropolis_hastings.PRESETS["paper"], (1.0, 4.0, 16.0, 64.0), swaps=True),
}


class Tempered:
    """Chains that advance together: all flights of a round are complete, in any batches, before the next round is drawn.

    All chains begin at the first guess, which is flown once. A step of the walk must be symmetric, as that of `Reach.ALL` is.
    """

    def __init__(self, name: str, settings: TemperedSettings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin all chains at the first guess."""
        self._space, self._rng = space, rng
        first, count = space.clip(first_guess), len(self.settings.temperatures)
        self._samples: Parameters = np.repeat(first[None], count, axis=0)
        self._energies: Floats = np.full(count, WORST)  # -log d at temperature 1
        self._phase, self._round = Phase.FIRST, first[None]
        self._reported: list[float] = []  # energies of the round, as far as its scores are reported
        self._chosen, self._chosen_energies = self._samples.copy(), self._energies.copy()
        self._gains: Floats = np.zeros(count)  # log of the summed scores of all tries
        self._steps = 0

    def ask(self, n: int) -> Parameters:
        """The rest of the round, at most n, shape (1 to n, S, K)."""
        return self._round[len(self._reported) : len(self._reported) + n].copy()

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Accept or reject the proposals of every chain whose part of the round is complete.

        Returns:
            Shape (B,), True where a proposal is accepted; always False with several tries, where reference points are flown before the
            decision.
        """
        accepted = np.zeros(len(parameters), dtype=np.bool_)
        for i, cost in enumerate(scores.cost.tolist()):
            cost = min(cost, WORST) if math.isfinite(cost) else WORST  # noqa: PLW2901  the same cost, made finite
            self._reported.append(negative_log_score(self.settings.walk.score, cost))
            if self._phase is Phase.FIRST:
                self._energies[:] = self._reported[-1]
                accepted[i] = True
            elif self._phase is Phase.TRIES and self.settings.tries == 1:
                chain = len(self._reported) - 1
                self._choose(chain, self._round[chain : chain + 1], np.array(self._reported[-1:]))
                accepted[i] = self._decide(chain, np.empty(0))
            if len(self._reported) == len(self._round):
                self._finish()
        return accepted

    def state(self) -> dict[str, Any]:
        """Chains, the current round and the random generator."""
        arrays = {name: getattr(self, f"_{name}").tolist() for name in _ARRAYS}
        return {
            **arrays,
            "reported": [*self._reported],
            "phase": str(self._phase),
            "steps": self._steps,
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`."""
        for name in _ARRAYS:
            setattr(self, f"_{name}", np.array(state[name]))
        self._reported, self._phase, self._steps = [*state["reported"]], Phase(state["phase"]), state["steps"]
        self._rng.bit_generator.state = state["rng"]

    def _finish(self) -> None:
        """Take the decisions that are left at the end of a round, and draw the next round."""
        tries, count = self.settings.tries, len(self._samples)
        energies = np.array(self._reported)
        if self._phase is Phase.TRIES and tries > 1:
            for chain in range(count):
                mine = slice(chain * tries, (chain + 1) * tries)
                self._choose(chain, self._round[mine], energies[mine])
            self._begin(Phase.REFERENCES, self._chosen, tries - 1)
            return
        if self._phase is Phase.REFERENCES:
            for chain in range(count):
                self._decide(chain, energies[chain * (tries - 1) : (chain + 1) * (tries - 1)])
        if self._phase is not Phase.FIRST and self.settings.swaps:
            self._swap()
        self._begin(Phase.TRIES, self._samples, tries)

    def _begin(self, phase: Phase, centres: Parameters, each: int) -> None:
        """Draw a round: `each` proposals from the centre of each chain."""
        walk = self.settings.walk
        drawn = [propose(walk, self._space, self._rng, centre, failed=-1) for centre in centres for _ in range(each)]
        self._phase, self._round, self._reported = phase, np.array(drawn), []

    def _choose(self, chain: int, tries: Parameters, energies: Floats) -> None:
        """Choose one of the tries of a chain with a probability proportional to its score."""
        scores = -energies / self.settings.temperatures[chain]
        perturbed = scores + self._rng.gumbel(size=len(scores)) if len(scores) > 1 else scores  # the largest is a draw ~ exp(scores)
        index = int(np.argmax(perturbed))
        self._chosen[chain], self._chosen_energies[chain] = tries[index], energies[index]
        self._gains[chain] = np.logaddexp.reduce(scores)

    def _decide(self, chain: int, references: Floats) -> bool:
        """Accept the chosen try with min(1, sum_j d(y_j) / sum_j d(x*_j)), x*_k = x; of one try that is the paper's rule."""
        scores = -np.append(references, self._energies[chain]) / self.settings.temperatures[chain]
        accepted = bool(np.logaddexp.reduce(scores) - self._gains[chain] <= self._rng.standard_exponential())
        if accepted:
            self._samples[chain], self._energies[chain] = self._chosen[chain], self._chosen_energies[chain]
        return accepted

    def _swap(self) -> None:
        """Exchange samples of neighbours with probability min(1, exp((1/T_i - 1/T_j) (E_i - E_j))); pairs alternate between steps."""
        temperatures = self.settings.temperatures
        for i in range(self._steps % 2, len(temperatures) - 1, 2):
            gain = (1 / temperatures[i] - 1 / temperatures[i + 1]) * (self._energies[i] - self._energies[i + 1])
            if -gain <= self._rng.standard_exponential():
                self._samples[[i, i + 1]] = self._samples[[i + 1, i]]
                self._energies[[i, i + 1]] = self._energies[[i + 1, i]]
        self._steps += 1


_ARRAYS = ("samples", "energies", "round", "chosen", "chosen_energies", "gains")
