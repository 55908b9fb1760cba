"""Descent by estimated gradients of the cost, in logarithms: do gradients work here?

Two estimates, both of central differences:
- SPSA: all parameters are shaken at once, two flights a gradient whatever their number (Spall, IEEE TAC 1992).
- Finite differences: one parameter after the other, 2 d flights a gradient; d is K where segments are tied (10 flights for five
  parameters), else S K (70 for seven segments: with 200 flights, not three steps).

Gains fall as Spall recommends (IEEE TAES 1998), and a step is a gain times the gradient over its typical size, or times Adam's
direction (Kingma, Ba, ICLR 2015). Near a bound the place steps back, so that both points lie within (Sadegh, Automatica 1997).
What descends is log(1 + cost).
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

ALPHA, GAMMA = 0.602, 0.101  # how gain and shake fall, Spall, 1998
MOMENTUM, MEMORY, EPSILON = 0.9, 0.999, 1e-8  # beta_1, beta_2, epsilon of Adam


class Estimate(StrEnum):
    """How a gradient is measured."""

    SIMULTANEOUS = "simultaneous"
    FINITE_DIFFERENCES = "finite_differences"


class UpdateRule(StrEnum):
    """How a gradient becomes a step."""

    GAINS = "gains"
    ADAM = "adam"


@dataclass(frozen=True)
class GradientSettings:
    """What tells one descent from another.

    Attributes:
        estimate: of the gradient.
        rule: of the steps.
        step: a_0, typical size of the first step of a parameter, in natural logarithms times the space's `log_step`.
        shake: c, half the distance of the two points of a difference, likewise.
        stability: A, steps after which gains begin to fall: a tenth of those in 200 flights.
        averages: simultaneous gradients of a step, two flights each.
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
    """A step at a time: fly pairs of points around a place, and move it. The first guess is flown first, alone.

    The place itself is not flown again: what holds must hold at the points around it.
    """

    def __init__(self, name: str, settings: GradientSettings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin at the first guess."""
        self._rng, self._offsets = rng, Offsets(space, space.clip(first_guess), self.settings.tied)
        self._low, self._high = self._offsets.bounds
        self._place = np.zeros(len(self._low))  # an offset from the first guess
        self._momentum, self._square = np.zeros_like(self._place), np.zeros_like(self._place)
        self._directions = np.zeros((0, len(self._place)))  # of the step under way; none while the first guess is flown
        self._values: list[float] = []  # of the points told
        self._steps, self._best, self._worst = 0, math.inf, 0.0

    def ask(self, n: int) -> Parameters:
        """What is left of a step, at most n, shape (1 to n, S, K); the same until it is told."""
        told = len(self._values)
        return self._offsets.decode(self._points()[told : told + n])

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:  # noqa: ARG002  they were asked for in order
        """Collect differences; when they are whole, move. True where a flight was the best so far."""
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
        """Place, moments, the step under way and the random generator."""
        return {
            **{name: getattr(self, f"_{name}").tolist() for name in ("place", "momentum", "square", "directions")},
            "values": [_plain(value) for value in self._values],
            "steps": self._steps,
            "best": _plain(self._best),
            "worst": self._worst,
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go on where `state()` was taken."""
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
        """Step down the gradient, if there is one yet, and choose the directions of the next."""
        if len(self._directions):
            self._place = self._place - self._step(self._gradient())
            self._steps += 1
        margin = np.minimum(self.settings.width(self._steps), (self._high - self._low) / 2)
        self._place = np.clip(self._place, self._low + margin, self._high - margin)
        self._directions, self._values = self._shake(), []

    def _shake(self) -> Floats:
        """Directions: all signs by chance, or one parameter each, in an order by chance; shape (count, d)."""
        size = len(self._place)
        if self.settings.estimate is Estimate.SIMULTANEOUS:
            return self._rng.choice([-1.0, 1.0], (self.settings.averages, size))
        return np.eye(size)[self._rng.permutation(size)]

    def _gradient(self) -> Floats:
        """g = sum_j (y_j+ - y_j-) / (2 c) D_j, shape (d,); for SPSA the mean over j (Spall, 1992; 1 / D = D for signs).

        A value that is not finite counts as one more than the worst so far.
        """
        plus, minus = np.nan_to_num(self._values, posinf=self._worst + 1.0).reshape(-1, 2).T
        slopes = (plus - minus) / (2 * self.settings.width(self._steps))
        total = slopes @ self._directions
        return total / len(slopes) if self.settings.estimate is Estimate.SIMULTANEOUS else total

    def _step(self, gradient: Floats) -> Floats:
        """What is subtracted from the place, shape (d,)."""
        k = self._steps + 1
        if self.settings.rule is UpdateRule.ADAM:
            self._momentum = MOMENTUM * self._momentum + (1 - MOMENTUM) * gradient
            self._square = MEMORY * self._square + (1 - MEMORY) * gradient**2
            mean, square = self._momentum / (1 - MOMENTUM**k), self._square / (1 - MEMORY**k)
            return self.settings.gain(self._steps) * mean / (np.sqrt(square) + EPSILON)
        self._square = self._square + (gradient**2 - self._square) / k
        typical = math.sqrt(float(self._square.mean()))  # so that a_0 moves a parameter by `step`; of all gradients, not the first only
        return self.settings.gain(self._steps) * gradient / typical if typical > 0 else gradient


def _plain(value: float) -> float | None:
    """A value in JSON, which has no infinity."""
    return value if math.isfinite(value) else None
