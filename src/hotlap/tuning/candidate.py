"""Candidate: parameters that a tuner asked for, with the means over their flights; and the score that is reported to the tuner."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hotlap.core.parameters import Parameters
from hotlap.core.plain import typed
from hotlap.core.records import Floats, Scores
from hotlap.core.shown import Shown
from hotlap.tuning.goal import Goal

WORST: Mapping[str, float] = {"cost": float("inf"), "lap_time": float("nan")}  # of what need not be finite


@dataclass(frozen=True, repr=False)
class Candidate(Shown):
    """Parameters, and the means over their flights so far.

    Attributes:
        parameters: shape (S, K).
        cost: mean over its flights; infinite where one of them has none.
        completion: mean over its flights.
        lap_time: [s] mean over its complete flights; NaN without any.
        flights: how many, re-flights included.
        confirmed: whether it met the goal in all re-flights and, where that is asked for, in enough validation flights.
        validation_rate: share of its validation flights that succeeded, where these were too few; else 0.
    """

    parameters: Parameters
    cost: float
    completion: float
    lap_time: float
    flights: int
    confirmed: bool
    validation_rate: float = 0.0

    @property
    def rank(self) -> tuple[bool, float, float, float]:
        """Larger is better: confirmed, then the rate of a failed validation, then completion, then cost."""
        return self.confirmed, self.validation_rate, self.completion, -self.cost

    def dump(self) -> dict[str, Any]:
        """As plain JSON, which has no NaN and no infinity."""
        plain = {name: value if np.isfinite(value) else None for name, value in vars(self).items() if name != "parameters"}
        return {"parameters": self.parameters.tolist(), **plain}

    @staticmethod
    def load(plain: Mapping[str, Any]) -> Candidate:
        """The inverse of `dump`."""
        known = {name: WORST.get(name) if value is None else value for name, value in plain.items()}
        return Candidate(**{**typed(Candidate, known), "parameters": np.array(plain["parameters"])})


def summarise(parameters: Parameters, flown: Scores, confirmed: bool, validation_rate: float) -> Candidate:
    """The candidate of some parameters, shape (S, K), with means over their flights."""
    laps, cost = flown.lap_time[np.isfinite(flown.lap_time)], float(flown.cost.mean())
    return Candidate(
        parameters=parameters,
        cost=cost if np.isfinite(cost) else float("inf"),
        completion=float(flown.completion.mean()),
        lap_time=float(laps.mean()) if len(laps) else float("nan"),
        flights=len(flown),
        confirmed=confirmed,
        validation_rate=validation_rate,
    )


def reported_scores(flown: Scores, goal: Goal, caution: float = 0.0) -> Scores:
    """The score of a candidate that is reported to the tuner, one row, from all its flights.

    Costs and gate misses are means over the flights; the rest is that of the last flight that failed or, if none did, of the last.

    Args:
        flown: all its flights.
        goal: that makes one a failure.
        caution: standard deviations over the flights by which a gate's miss counts as more than its mean.
    """
    failed = np.flatnonzero(~goal.met(flown))
    last = int(failed[-1]) if len(failed) else len(flown) - 1
    means = {name: np.mean(getattr(flown, name), axis=0, keepdims=True) for name in ("cost", "dense")}
    return replace(flown.rows(slice(last, last + 1)), gate_miss=_misses(flown, caution), **means)


def _misses(flown: Scores, caution: float) -> Floats:
    """The miss at each gate over the flights that got there, shape (1, M); NaN where none did."""
    reached = np.isfinite(flown.gate_miss)
    misses = np.where(reached, flown.gate_miss, 0.0)
    with np.errstate(invalid="ignore"):
        mean = misses.sum(axis=0, keepdims=True) / reached.sum(axis=0)
        if not caution:
            return mean
        return mean + caution * np.sqrt((np.where(reached, misses - mean, 0.0) ** 2).sum(axis=0, keepdims=True) / reached.sum(axis=0))
