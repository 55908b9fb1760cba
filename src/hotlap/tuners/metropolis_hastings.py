"""Metropolis-Hastings sampling of controller parameters (Sec. IV-A of the paper)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.parameters import Parameters, ParameterSpace
from hotlap.records import Scores


class Scale(StrEnum):
    """Where steps are Gaussian: in the parameters' own units, or in their natural logarithm."""

    RAW = "raw"
    LOG = "log"


@dataclass(frozen=True)
class Settings:
    """What tells one sampler from another.

    Attributes:
        sigma: standard deviation of a step: raw units, or natural logarithm times the space's `log_step`.
        scale: where steps are Gaussian.
        tied: share of the moves that take one step for all segments; the others move each segment by itself.
        temperature: T of the score d(w) = exp(-m(w) / T); the paper's is 1.
        rollback: return to the current sample after a rejection, as the paper says; the released code goes on from the proposal.
    """

    sigma: float
    scale: Scale
    tied: float
    temperature: float = 1.0
    rollback: bool = True


PRESETS: Mapping[str, Settings] = {
    "tied": Settings(sigma=0.3, scale=Scale.LOG, tied=1.0),
    "paper": Settings(sigma=5.0, scale=Scale.RAW, tied=0.0),  # sigma = 5, Sec. IV-A
}


class MetropolisHastings:
    """A random walk that always accepts better parameters, and worse ones with probability d(w')/d(w).

    The transition is symmetric (Gaussian, mirrored at the bounds), so that no Hastings factor is needed; with `Scale.LOG` the
    stationary density is taken with respect to the logarithms. Each `ask` gives one proposal, the same one until it is told.
    """

    def __init__(self, name: str, settings: Settings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin a chain at the first guess."""
        self._space, self._rng = space, rng
        self._sample: Parameters = space.clip(first_guess)
        self._cost: float | None = None  # of the current sample; None before it was flown
        self._proposal: Parameters | None = self._sample

    def ask(self, n: int) -> Parameters:  # noqa: ARG002  a chain uses one at a time
        """The proposal, shape (1, S, K), whatever n; the first one is the first guess."""
        if self._proposal is None:
            self._proposal = self._propose()
        return self._proposal[None].copy()

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Accept the proposal, or keep the current sample."""
        return np.array([self._step(*flown) for flown in zip(parameters, scores.cost.tolist(), strict=True)])

    def state(self) -> dict[str, Any]:
        """Sample, its cost, a proposal under way and the random generator."""
        return {
            "sample": self._sample.tolist(),
            "cost": "inf" if self._cost == math.inf else self._cost,  # JSON has no infinity
            "proposal": None if self._proposal is None else self._proposal.tolist(),
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go on where `state()` was taken."""
        self._sample = np.array(state["sample"])
        self._cost = None if state["cost"] is None else float(state["cost"])
        self._proposal = None if state["proposal"] is None else np.array(state["proposal"])
        self._rng.bit_generator.state = state["rng"]

    def _propose(self) -> Parameters:
        """A Gaussian step from the current sample, mirrored at the bounds."""
        segments, size = self._sample.shape
        tied = self._rng.random() < self.settings.tied
        step = self.settings.sigma * self._rng.standard_normal((1 if tied else segments, size))  # w' ~ N(w, sigma^2), Sec. IV-A
        if self.settings.scale is Scale.LOG:
            logarithms = self._space.reflect_log(np.log(self._sample) + step * self._space.log_step)
            return self._space.clip(np.exp(logarithms))
        return self._space.reflect(self._sample + step)

    def _step(self, proposal: Parameters, cost: float) -> bool:
        """Decide about one proposal; costs are compared by their logarithmic scores, because exp(-300) is 0."""
        cost = cost if math.isfinite(cost) else math.inf
        threshold = self._rng.standard_exponential()  # -log u, drawn whether or not it is needed: one step, one draw
        accepted = self._cost is None or cost <= self._cost
        if self._cost is not None and not accepted:
            worse = (cost - self._cost) / self.settings.temperature  # -log alpha
            accepted = worse < threshold  # u < alpha = min(1, d(w')/d(w)), d(w) = exp(-m(w) / T), Sec. IV-A, Eq. 5
        if accepted:
            self._cost = cost
        if accepted or not self.settings.rollback:
            self._sample = proposal.copy()
        self._proposal = None
        return accepted
