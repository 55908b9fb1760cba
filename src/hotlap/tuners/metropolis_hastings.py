"""Metropolis-Hastings sampling of controller parameters (Sec. IV-A of the paper), and the rules of the released code."""

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

WINDOW = (1.0, 0.75, 0.5, 0.25)  # of sigma: the failed segment and the three before it, released code
HORIZON = "horizon"


class Scale(StrEnum):
    """The scale in which steps are Gaussian: the parameters' own units, or their natural logarithms."""

    RAW = "raw"
    LOG = "log"


class Score(StrEnum):
    """Score d of a cost m: exp(-m / T) in the paper (Eq. 5), exp(-2 sqrt(m) / T) in the released code."""

    EXPONENTIAL = "exponential"
    ROOT = "root"


class Reach(StrEnum):
    """Segments that a step changes: all in the paper; the failed one and the three before it in the released code."""

    ALL = "all"
    FAILED = "failed"


@dataclass(frozen=True)
class MetropolisHastingsSettings:
    """Settings of the sampler.

    Attributes:
        sigma: standard deviation of a step: raw units, or natural logarithm times the space's `log_step`.
        scale: scale in which steps are Gaussian.
        tied: probability that a move takes the same step in all segments; the other moves take a step of its own in each segment.
        temperature: T of the score; the paper's is 1.
        rollback: keep the current sample after a rejection, as in the paper; the released code continues from the rejected proposal.
        score: score of a cost.
        reach: segments that a step changes.
        horizon: size of the horizon's step relative to that of the other parameters; the released code's is a tenth.
    """

    sigma: float
    scale: Scale
    tied: float
    temperature: float = 1.0
    rollback: bool = True
    score: Score = Score.EXPONENTIAL
    reach: Reach = Reach.ALL
    horizon: float = 1.0


_RELEASED = {"score": Score.ROOT, "reach": Reach.FAILED, "horizon": 0.1}

PRESETS: Mapping[str, MetropolisHastingsSettings] = {
    "tied": MetropolisHastingsSettings(sigma=0.3, scale=Scale.LOG, tied=1.0),
    "paper": MetropolisHastingsSettings(sigma=5.0, scale=Scale.RAW, tied=0.0),  # sigma = 5, Sec. IV-A
    "untied_log": MetropolisHastingsSettings(sigma=0.3, scale=Scale.LOG, tied=0.0),
    "released": MetropolisHastingsSettings(sigma=5.0, scale=Scale.RAW, tied=0.0, rollback=False, **_RELEASED),
    "released_rollback": MetropolisHastingsSettings(sigma=5.0, scale=Scale.RAW, tied=0.0, **_RELEASED),
    "released_log": MetropolisHastingsSettings(sigma=0.3, scale=Scale.LOG, tied=0.0, **_RELEASED),
}


class MetropolisHastings:
    """A random walk that always accepts better parameters, and worse ones with probability d(w')/d(w).

    The transition is symmetric (Gaussian, mirrored at the bounds), so that no Hastings factor is needed; with `Scale.LOG` the
    stationary density is taken with respect to the logarithms. Each `ask` gives one proposal, the same one until its score is reported.
    With `Reach.FAILED` the step depends on where the current sample failed and is not symmetric; as in the released code, there is no
    factor for that. It differs from the released code in that proposals are mirrored at the bounds, not redrawn.

    Attributes:
        temperature: T of the next decision; at first that of the settings.
    """

    def __init__(self, name: str, settings: MetropolisHastingsSettings) -> None:
        self.name, self.settings = name, settings
        self.temperature = settings.temperature

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin a chain at the first guess."""
        self._space, self._rng = space, rng
        self._sample: Parameters = space.clip(first_guess)
        self._cost: float | None = None  # of the current sample; None before it was flown
        self._failed = -1  # segment in which the current sample failed; -1 for none
        self._proposal: Parameters | None = self._sample

    def ask(self, n: int) -> Parameters:  # noqa: ARG002  a chain uses one at a time
        """The proposal, shape (1, S, K), whatever n; the first one is the first guess."""
        if self._proposal is None:
            self._proposal = propose(self.settings, self._space, self._rng, self._sample, self._failed)
        return self._proposal[None].copy()

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:
        """Accept the proposal, or keep the current sample."""
        flown = zip(parameters, scores.cost.tolist(), scores.failed_segment.tolist(), strict=True)
        return np.array([self._step(*flight) for flight in flown])

    def state(self) -> dict[str, Any]:
        """Sample, its cost and failed segment, the current proposal and the random generator."""
        return {
            "sample": self._sample.tolist(),
            "cost": "inf" if self._cost == math.inf else self._cost,  # JSON has no infinity
            "failed": self._failed,
            "proposal": None if self._proposal is None else self._proposal.tolist(),
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`."""
        self._sample = np.array(state["sample"])
        self._cost = None if state["cost"] is None else float(state["cost"])
        self._failed = state.get("failed", -1)  # studies of earlier versions have none
        self._proposal = None if state["proposal"] is None else np.array(state["proposal"])
        self._rng.bit_generator.state = state["rng"]

    def _step(self, proposal: Parameters, cost: float, failed: int) -> bool:
        """Decide about one proposal."""
        cost = cost if math.isfinite(cost) else math.inf
        threshold = self._rng.standard_exponential()  # drawn whether or not it is needed: one step, one draw
        accepted = self._cost is None or bool(accepts(self.settings.score, self.temperature, cost, self._cost, threshold))
        if accepted:
            self._cost, self._failed = cost, failed
        if accepted or not self.settings.rollback:
            self._sample = proposal.copy()
        self._proposal = None
        return accepted


def propose(
    settings: MetropolisHastingsSettings, space: ParameterSpace, rng: np.random.Generator, sample: Parameters, failed: int
) -> Parameters:
    """A Gaussian step from a sample, mirrored at the bounds.

    Args:
        settings: sizes of the step.
        space: bounds.
        rng: random generator.
        sample: shape (S, K).
        failed: segment in which the sample failed; -1 for none.
    """
    segments, size = sample.shape
    tied = rng.random() < settings.tied
    step = settings.sigma * rng.standard_normal((1 if tied else segments, size))  # w' ~ N(w, sigma^2), Sec. IV-A
    if settings.horizon != 1.0:
        step[:, [name == HORIZON for name in space.names]] *= settings.horizon
    if settings.reach is Reach.FAILED:
        step = step * window(segments, failed)[:, None]
    if settings.scale is Scale.LOG:
        moved = step.any(axis=1, keepdims=True)  # exp(log(w)) is not w to the last bit
        logarithms = space.reflect_log(np.log(sample) + step * space.log_step)
        return np.where(moved, space.clip(np.exp(logarithms)), sample)
    return space.reflect(sample + step)


def window(segments: int, failed: int) -> NDArray[np.float64]:
    """Share of sigma that each segment moves by, shape (S,): `WINDOW` backwards from the failed one, from the last after a full lap."""
    last = failed if failed >= 0 else segments - 1
    behind = last - np.arange(segments)
    return np.where((behind >= 0) & (behind < len(WINDOW)), np.take(WINDOW, behind, mode="clip"), 0.0)


def accepts(score: Score, temperature: float, proposed: Any, current: Any, threshold: Any) -> Any:
    """Whether a proposal is accepted: u < alpha = min(1, d(w') / d(w)), Sec. IV-A; elementwise.

    Scores are compared by their logarithms, because exp(-300) is 0. Of two infinite costs neither is worse.

    Args:
        score: of a cost.
        temperature: T of the score.
        proposed: cost of the proposal, a number or an array.
        current: cost of the current sample.
        threshold: -log u, u uniform in (0, 1).
    """
    with np.errstate(invalid="ignore"):  # infinity minus infinity
        rise = (negative_log_score(score, proposed) - negative_log_score(score, current)) / temperature
    return (proposed <= current) | (rise < threshold)


def negative_log_score(score: Score, cost: Any) -> Any:
    """-log d of a cost, a number or an array, at temperature 1; infinite where the cost is."""
    return cost if score is Score.EXPONENTIAL else 2.0 * np.sqrt(np.maximum(cost, 0.0))  # d = exp(-m), Eq. 5; exp(-2 sqrt m), released code
