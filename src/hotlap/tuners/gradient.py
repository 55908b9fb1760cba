"""Gradient descent on the cost, in logarithms of the parameters, with gradients estimated by finite differences of noisy flights.

Two estimates, both by central differences:
- SPSA: all parameters are perturbed at once, two flights for a gradient whatever their number (Spall, IEEE TAC 1992).
- Finite differences: one parameter after the other, 2 d flights for a gradient; d is K where segments are tied (10 flights for five
  parameters), else S K (70 for seven segments: fewer than three steps in 200 flights).

Gains decrease as Spall recommends (IEEE TAES 1998); a step is a gain times the gradient over its root mean square, or times Adam's
direction (Kingma, Ba, ICLR 2015). Near a bound the iterate is moved inwards, so that both perturbed points lie within (Sadegh, Automatica
1997). The function that is minimised is log(1 + cost).
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
from hotlap.tuners.offsets import Offsets

Floats = NDArray[np.float64]

ALPHA, GAMMA = 0.602, 0.101  # exponents by which gain and perturbation decrease, Spall, 1998
MOMENTUM, MEMORY, EPSILON = 0.9, 0.999, 1e-8  # beta_1, beta_2, epsilon of Adam


class Estimate(StrEnum):
    """How the gradient is estimated."""

    SIMULTANEOUS = "simultaneous"
    FINITE_DIFFERENCES = "finite_differences"


class UpdateRule(StrEnum):
    """How the step is computed from the gradient."""

    GAINS = "gains"
    ADAM = "adam"


@dataclass(frozen=True)
class GradientSettings:
    """Settings of gradient descent.

    Attributes:
        estimate: how the gradient is estimated.
        rule: how the step is computed.
        step: a_0, typical size of the first step of a parameter, in natural logarithms times the space's `log_step`.
        shake: c, half the distance of the two points of a difference, in the same unit.
        stability: A, number of steps after which the gains begin to decrease: a tenth of the steps in 200 flights.
        averages: number of simultaneous gradients that are averaged for a step, two flights each.
        tied: one step for all segments.
        dense: use the dense cost, which is smooth, else the metric.
    """

    estimate: Estimate = Estimate.SIMULTANEOUS
    rule: UpdateRule = UpdateRule.GAINS
    step: float = 0.3
    shake: float = 0.3
    stability: int = 10
    averages: int = 1
    tied: bool = True
    dense: bool = True

    def gain(self, k: int) -> float:
        """a_k = a / (A + k + 1)^0.602 with a such that a_0 = `step`; k counts from 0."""
        return self.step * ((self.stability + 1) / (self.stability + k + 1)) ** ALPHA

    def width(self, k: int) -> float:
        """c_k = c / (k + 1)^0.101."""
        return self.shake / (k + 1) ** GAMMA


PRESETS: Mapping[str, GradientSettings] = {
    "spsa": GradientSettings(),
    "spsa_metric": GradientSettings(dense=False),
    "spsa_averaged": GradientSettings(averages=4),
    "spsa_segments": GradientSettings(tied=False),
    "spsa_adam": GradientSettings(rule=UpdateRule.ADAM),
    "finite_differences": GradientSettings(Estimate.FINITE_DIFFERENCES, stability=2),
    "finite_differences_segments": GradientSettings(Estimate.FINITE_DIFFERENCES, stability=0, tied=False),
}


class Gradient:
    """Each step flies pairs of points around the current iterate, then moves it. The first guess is flown first, alone.

    The iterate itself is not flown again: the flights that can be confirmed are those of the points around it.
    """

    def __init__(self, name: str, settings: GradientSettings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin at the first guess."""
        self._rng, self._offsets = rng, Offsets(space, space.clip(first_guess), self.settings.tied)
        self._low, self._high = self._offsets.bounds
        self._place = np.zeros(len(self._low))  # the iterate, as an offset from the first guess
        self._momentum, self._square = np.zeros_like(self._place), np.zeros_like(self._place)
        self._directions = np.zeros((0, len(self._place)))  # of the current step; none while the first guess is flown
        self._values: list[float] = []  # log(1 + cost) of the points of the step, as far as reported
        self._steps, self._best, self._worst = 0, math.inf, 0.0

    def ask(self, n: int) -> Parameters:
        """The rest of the points of a step, at most n, shape (1 to n, S, K); the same until their scores are reported."""
        flown = len(self._values)
        return self._offsets.decode(self._points()[flown : flown + n])

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:  # noqa: ARG002  they were asked for in order
        """Collect the costs of a step and, when they are complete, move. True where a flight has the lowest cost so far."""
        better = []
        for cost in (scores.dense if self.settings.dense else scores.cost).tolist():
            value = math.log1p(max(cost, 0.0)) if math.isfinite(cost) else math.inf
            better.append(value < math.inf and value <= self._best)
            self._best = min(self._best, value)
            self._worst = max(self._worst, value) if value < math.inf else self._worst
            self._values.append(value)
        if len(self._values) == len(self._points()):
            self._move()
        return np.array(better, dtype=np.bool_)

    def state(self) -> dict[str, Any]:
        """Iterate, moments, the current step and the random generator."""
        return {
            **{name: getattr(self, f"_{name}").tolist() for name in ("place", "momentum", "square", "directions")},
            "values": [_plain(value) for value in self._values],
            "steps": self._steps,
            "best": _plain(self._best),
            "worst": self._worst,
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`."""
        self._place, self._momentum, self._square = (np.array(state[name]) for name in ("place", "momentum", "square"))
        self._directions = np.array(state["directions"]).reshape(-1, len(self._place))
        self._values = [math.inf if value is None else value for value in state["values"]]
        self._best = math.inf if state["best"] is None else state["best"]
        self._steps, self._worst = state["steps"], state["worst"]
        self._rng.bit_generator.state = state["rng"]

    def _points(self) -> Floats:
        """The points of a step, x + c D_j and x - c D_j in turn, or the first guess, shape (count, d)."""
        if not len(self._directions):
            return self._place[None]
        shakes = self.settings.width(self._steps) * np.stack([self._directions, -self._directions], axis=1)
        return np.clip(self._place + shakes.reshape(-1, len(self._place)), self._low, self._high)

    def _move(self) -> None:
        """Move against the gradient, if there is one yet, and choose the directions of the next step."""
        if len(self._directions):
            self._place = self._place - self._step(self._gradient())
            self._steps += 1
        margin = np.minimum(self.settings.width(self._steps), (self._high - self._low) / 2)
        self._place = np.clip(self._place, self._low + margin, self._high - margin)
        self._directions, self._values = self._shake(), []

    def _shake(self) -> Floats:
        """Directions: vectors of random signs, or one axis each in random order; shape (count, d)."""
        size = len(self._place)
        if self.settings.estimate is Estimate.SIMULTANEOUS:
            return self._rng.choice([-1.0, 1.0], (self.settings.averages, size))
        return np.eye(size)[self._rng.permutation(size)]

    def _gradient(self) -> Floats:
        """g = sum_j (y_j+ - y_j-) / (2 c) D_j, shape (d,); for SPSA the mean over j (Spall, 1992; 1 / D = D for signs).

        A value that is not finite counts as the largest so far plus 1.
        """
        plus, minus = np.nan_to_num(self._values, posinf=self._worst + 1.0).reshape(-1, 2).T
        slopes = (plus - minus) / (2 * self.settings.width(self._steps))
        total = slopes @ self._directions
        return total / len(slopes) if self.settings.estimate is Estimate.SIMULTANEOUS else total

    def _step(self, gradient: Floats) -> Floats:
        """The vector that is subtracted from the iterate, shape (d,)."""
        k = self._steps + 1
        if self.settings.rule is UpdateRule.ADAM:
            self._momentum = MOMENTUM * self._momentum + (1 - MOMENTUM) * gradient
            self._square = MEMORY * self._square + (1 - MEMORY) * gradient**2
            mean, square = self._momentum / (1 - MOMENTUM**k), self._square / (1 - MEMORY**k)
            return self.settings.gain(self._steps) * mean / (np.sqrt(square) + EPSILON)
        self._square = self._square + (gradient**2 - self._square) / k
        typical = math.sqrt(float(self._square.mean()))  # so that a_0 moves a parameter by `step`; of all gradients, not only of the first
        return self.settings.gain(self._steps) * gradient / typical if typical > 0 else gradient


def _plain(value: float) -> float | None:
    """A value as JSON, which has no infinity."""
    return value if math.isfinite(value) else None
