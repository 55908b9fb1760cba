"""Robustness: tuned parameters flown under conditions that differ a little from those that they were tuned under."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.analysis.diagnosis import Diagnosis, cheap_replan, diagnose, telling
from hotlap.core.parameters import Parameters
from hotlap.core.records import Scores
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.core.shown import Shown
from hotlap.core.success_rate import Validation
from hotlap.feasibility.demands import needed_vectors
from hotlap.feasibility.margins import Margin, margin
from hotlap.race.conditions import DEFAULT_CONDITIONS, UNCHANGED, Condition, join_conditions
from hotlap.reference.scenario import Scenario
from hotlap.tuning.goal import Goal
from hotlap.tuning.under_conditions import fly_under
from hotlap.worlds.world import World

FLIGHTS = 50  # under each condition
HELD = 0.95  # share of successes from which on parameters hold under a condition


@dataclass(frozen=True, repr=False)
class Robustness(Shown):
    """Success rate of parameters under one condition.

    Attributes:
        condition: what is different.
        validation: flights that met the goal.
        asked: whether somebody asked for this condition; else it is one that every tuned controller is asked to bear.
        margin: of thrust under it; None where that was not computed.
        causes: why flights fail, the likeliest first; empty where enough succeed, or nobody asked.
    """

    condition: Condition
    validation: Validation
    asked: bool = False
    margin: Margin | None = None
    causes: tuple[Diagnosis, ...] = ()

    def dump(self) -> dict[str, Any]:
        """As plain JSON, in the keys of `robustness` of `hotlap tune --json`."""
        (low, high), validation = self.validation.interval, self.validation
        counts = {"flights": validation.flights, "successes": validation.successes, "rate": validation.rate}
        about = {"margin": None if self.margin is None else self.margin.dump(), "causes": [cause.dump() for cause in self.causes]}
        return {"change": self.change, "asked": self.asked, **counts, "low": low, "high": high, **about}

    @property
    def change(self) -> str:
        """What is different, in words."""
        return self.condition.name

    @property
    def holds(self) -> bool:
        """Whether enough flights met the goal: a share of `HELD`."""
        return self.validation.rate >= HELD


def check_robustness(
    scenario: Scenario,
    world: World,
    goal: Goal,
    parameters: Parameters,
    seed: int,
    flights: int = FLIGHTS,
    as_tuned: Scores | None = None,
    asked: Sequence[Condition] = (),
    further: Sequence[Condition] = DEFAULT_CONDITIONS,
    *,
    explained: bool = False,
) -> tuple[Robustness, ...]:
    """Fly parameters as they were tuned, and under conditions; the seeds are the same under each.

    Args:
        scenario: what they were tuned on.
        world: one that takes vehicle parameters for each flight.
        goal: what counts as a success.
        parameters: shape (S, K).
        seed: of the run.
        flights: under each condition.
        as_tuned: of flights without a change, with the same seeds; None: they are flown here.
        asked: conditions that somebody asked for.
        further: conditions that are flown as well.
        explained: whether to find out why flights under a condition fail.

    Returns:
        The first is `UNCHANGED`, then the conditions that were asked for, then the others, each once.
    """
    seeds = flight_seeds(seed, Stream.DEMONSTRATION, 0, flights)
    every = (UNCHANGED, *join_conditions(asked, further))
    known = {} if as_tuned is None else {UNCHANGED: as_tuned}
    found = known | fly_conditions(scenario, world, parameters, seeds, [one for one in every if one not in known])
    met = {condition: goal.succeeded(scores) for condition, scores in found.items()}
    vectors = needed_vectors(scenario.race.vehicle, scenario.reference)
    left = {one: margin(scenario.race, scenario.reference, one, offset_free=scenario.offset_free, vectors=vectors) for one in every}
    rows = [Robustness(one, Validation(flights, int(met[one].sum())), one in asked, left[one]) for one in every]
    if not explained:
        return tuple(rows)

    def explain(row: Robustness) -> Robustness:
        """The same with the causes of its failures."""
        some, replan = telling(seeds, ~met[row.condition]), None if row.condition.changes else cheap_replan(scenario)
        rate = row.validation.rate
        return replace(row, causes=diagnose(scenario, world, parameters, some, goal, row.condition, before=rate, replan=replan))

    return tuple(row if row.holds else explain(row) for row in rows)


def margin_of(scenario: Scenario, condition: Condition = UNCHANGED) -> Margin:
    """What is there over what a scenario's reference needs, under a condition."""
    return margin(scenario.race, scenario.reference, condition, offset_free=scenario.offset_free)


def fly_conditions(
    scenario: Scenario, world: World, parameters: Parameters, seeds: NDArray[np.int64], conditions: Sequence[Condition]
) -> dict[Condition, Scores]:
    """Fly parameters under conditions.

    Args:
        scenario: what is flown.
        world: one that takes vehicle parameters for each flight.
        parameters: shape (S, K).
        seeds: of the flights under each condition.
        conditions: each once.
    """
    if not conditions:
        return {}
    each, repeated = len(seeds), np.repeat(parameters[None], len(seeds) * len(conditions), axis=0)
    one_by_one = [condition for condition in conditions for _ in range(each)]
    scores = fly_under(scenario, world, repeated, np.tile(seeds, len(conditions)), one_by_one)
    return {condition: scores.rows(slice(i * each, (i + 1) * each)) for i, condition in enumerate(conditions)}
