"""Severity: how much of what was asked for parameters stand: 1 is all of it as written, 0.5 half of each change, 2 twice as much."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters
from hotlap.core.shown import Shown
from hotlap.race.conditions import UNCHANGED, Condition
from hotlap.reference.scenario import Scenario
from hotlap.tuning.under_conditions import fly_under
from hotlap.worlds.world import World

SEVERITIES = (0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0)
ASKED = SEVERITIES.index(1.0)
FALLS = -1.0  # what parameters stand that do not even fly the race as it is described


@dataclass(frozen=True, repr=False)
class Standing(Shown):
    """What parameters stand.

    Attributes:
        severity: the largest of `SEVERITIES` at which, as at all smaller ones that were flown, they succeed often enough under every
            condition; `FALLS` where they do not even without any.
        nominal: share [-] of flights without a condition that succeed.
        rates: share [-] of flights that succeed under each condition as it was asked for.
        lap: [s] mean lap of the flights without a condition; NaN without any.
    """

    severity: float
    nominal: float
    rates: tuple[float, ...]
    lap: float

    @property
    def rank(self) -> tuple[float, float]:
        """Larger is better."""
        return self.severity, min(self.rates)


def standing(
    scenario: Scenario, world: World, parameters: Parameters, conditions: Sequence[Condition], seeds: NDArray[np.int64], least: float
) -> Standing:
    """Fly parameters under conditions as they were asked for, and then more or less severe until it is known what they stand.

    Args:
        scenario: what is flown.
        world: one that takes vehicle parameters for each flight.
        parameters: shape (S, K).
        conditions: as they were asked for, at least one.
        seeds: of the flights under each condition.
        least: share of flights that must succeed under each.
    """

    def held(at: int) -> bool:
        """Whether enough flights succeed under each condition at one of `SEVERITIES`."""
        rates, _ = _fly(scenario, world, parameters, [condition.scaled(SEVERITIES[at]) for condition in conditions], seeds)
        return min(rates) >= least

    (nominal, *rates), lap = _fly(scenario, world, parameters, [UNCHANGED, *conditions], seeds)
    if nominal < least:
        return Standing(FALLS, nominal, tuple(rates), lap)
    at = ASKED
    if min(rates) >= least:
        while at + 1 < len(SEVERITIES) and held(at + 1):
            at += 1
    else:
        at -= 1
        while at > 0 and not held(at):
            at -= 1
    return Standing(SEVERITIES[at], nominal, tuple(rates), lap)


def _fly(
    scenario: Scenario, world: World, parameters: Parameters, conditions: Sequence[Condition], seeds: NDArray[np.int64]
) -> tuple[list[float], float]:
    """Share of flights that succeed under each condition, and the mean lap [s] under the first; NaN where no flight got there."""
    repeated = np.repeat(parameters[None], len(conditions) * len(seeds), axis=0)
    under = [condition for condition in conditions for _ in range(len(seeds))]
    scores = fly_under(scenario, world, repeated, np.tile(seeds, len(conditions)), under)
    laps = scores.lap_time[: len(seeds)]
    laps = laps[np.isfinite(laps)]
    return scores.complete.reshape(len(conditions), -1).mean(axis=1).tolist(), float(laps.mean()) if len(laps) else math.nan
