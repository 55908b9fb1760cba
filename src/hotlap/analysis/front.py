"""Front: lap time against what it stands: the fastest plan that holds under conditions, and what bolder and calmer ones stand.

Bolder plans leave less thrust and less room for what nobody planned. The search walks down a ladder of shares of the vehicle's thrust,
tunes each plan, narrows the share between the boldest plan that holds what was asked for and the next bolder one, then tries the other
settings of the planner around it. Every plan that it tried is a point; the front are those that no other plan beats in both.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hotlap import tuners
from hotlap.analysis.learning import built_in_world
from hotlap.analysis.plan_trials import (
    CHOSEN,
    FRESH,
    Do,
    PlanSettings,
    Trial,
    first_plan_settings,
    most_thrust,
    neighbours,
    tune_from,
    tune_plan,
)
from hotlap.analysis.severity import FALLS, Standing, standing
from hotlap.core.errors import HotlapError
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.core.shown import Shown
from hotlap.planning.preparation import prepare
from hotlap.race.conditions import UNCHANGED, Condition
from hotlap.race.race import Race
from hotlap.tuning.loop import TuningSettings, scenario_for
from hotlap.tuning.objective import Objective
from hotlap.tuning.under_conditions import UnderConditions

HELD = 0.95  # least share of flights that pass all gates, under each condition
LADDER = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4)  # of the thrust that vehicle and controller have
HOVERS = 1.2  # least thrust to weight of a plan
ROUNDS = 2  # of narrowing the thrust, and of steps along the other settings
NARROWED = (1 / 3, 2 / 3)  # of the way, in logarithms, from the plan that holds to the next bolder one
OTHERS = ("tolerance", "clearance", "v_max")
RANKED = 100  # flights under each condition by which plans are ranked
CONFIRM = 5  # re-flights of a candidate, under each condition


@dataclass(frozen=True, repr=False)
class Point(Shown):
    """A plan that was tried, tuned and flown.

    Attributes:
        plan_settings: what it was planned with.
        lap: [s] as flown.
        standing: what its parameters stand.
        parameters: of each segment.
        planned: [s] lap of the plan.
    """

    plan_settings: PlanSettings
    lap: float
    standing: Standing
    parameters: tuple[tuple[float, ...], ...]
    planned: float

    @property
    def holds(self) -> bool:
        """Whether it stands all that was asked for."""
        return self.standing.severity >= 1.0


def try_under_conditions(trial: Trial) -> Iterator[dict[str, Any]]:
    """Plan, tune, find what the parameters stand, and where that is too little, tune under the conditions; a reason without a plan."""
    try:
        scenario = scenario_for(prepare(trial.plan_settings.applied(trial.race)), tuners.build(trial.tuner))
    except HotlapError as error:
        yield {"reason": str(error)}
        return
    world = built_in_world()
    best, flights = tune_plan(trial, Objective(scenario, world))
    seeds = flight_seeds(trial.settings.seed, Stream.DEMONSTRATION, CHOSEN, RANKED)
    found = standing(scenario, world, best, trial.conditions, seeds, HELD)
    if FALLS < found.severity < 1.0:
        conditions = (UNCHANGED, *trial.conditions)
        count = len(conditions)
        settings = replace(trial.settings, samples=count, budget=trial.settings.budget * count, confirm=CONFIRM * count, validation=0)
        other, more = tune_from(trial.tuner, settings, UnderConditions(scenario, world, conditions=conditions), best)
        flights += more
        stands = standing(scenario, world, other, trial.conditions, seeds, HELD)
        if stands.rank > found.rank:
            best, found = other, stands
    yield {
        "lap": found.lap,
        "planned": scenario.reference.lap_time,
        "severity": found.severity,
        "nominal": found.nominal,
        "rates": list(found.rates),
        "flights": flights,
        "parameters": best.tolist(),
        "reason": "",
    }


def judge_under_conditions(trial: Trial) -> Iterator[dict[str, Any]]:
    """Fly parameters of a plan, `trial.parameters`, under each condition with noise other than that they were chosen by."""
    scenario = prepare(trial.plan_settings.applied(trial.race))
    seeds = flight_seeds(trial.settings.seed, Stream.DEMONSTRATION, FRESH, max(trial.settings.validation, 1))
    found = standing(scenario, built_in_world(), np.array(trial.parameters), trial.conditions, seeds, HELD)
    yield {"lap": found.lap, "severity": found.severity, "nominal": found.nominal, "rates": list(found.rates)}


def search(race: Race, tuner: str, settings: TuningSettings, conditions: tuple[Condition, ...], do: Do) -> list[Point]:
    """Try plans from bold to calm; all that could be flown, the soonest first.

    Args:
        race: its planning is where the search begins.
        tuner: algorithm with preset.
        settings: of each tuning.
        conditions: what a plan is to be held under, at least one.
        do: works trials off, by keys, and gives what `try_under_conditions` finds of each.
    """
    found: dict[PlanSettings, Point] = {}

    def try_plans(plans: Iterable[PlanSettings], begin: Point | None = None) -> None:
        """Try those that were not tried yet, from the parameters of a point; what can be flown becomes one."""
        start = None if begin is None else tuple(np.exp(np.log(begin.parameters).mean(axis=0)).tolist())
        trials = {
            plan.key: Trial(race, plan, tuner, settings, start, conditions=conditions) for plan in dict.fromkeys(plans) if plan not in found
        }
        results = do(trials)
        found.update(
            {trials[key].plan_settings: _point(trials[key].plan_settings, results[key]) for key in trials if results[key].get("lap")}
        )

    first = first_plan_settings(race)
    try_plans([first, *ladder(race)])
    for _ in range(ROUNDS):
        best = soonest(found.values())
        if best is None:
            break
        try_plans(between(best, found.values()), best)
        best = soonest(found.values()) or best
        try_plans(neighbours(race, best.plan_settings, 1.0, OTHERS), best)
    return sorted(found.values(), key=lambda point: point.lap)


def most_plans(race: Race) -> int:
    """How many plans `search` and `winner` fly at most, but for winners that do not hold a second time."""
    around = neighbours(race, first_plan_settings(race), 1.0, OTHERS)
    return 1 + len(ladder(race)) + ROUNDS * (len(NARROWED) + len(around)) + 1


def ladder(race: Race) -> list[PlanSettings]:
    """The race's plan with shares of the thrust that vehicle and controller have, down to little more than hovering needs."""
    first, most, model = first_plan_settings(race), most_thrust(race), race.planning_model
    shares = [share * most for share in LADDER if share * most * model.max_acceleration >= HOVERS * model.gravity]
    return [replace(first, thrust=share) for share in shares]


def between(best: Point, points: Iterable[Point]) -> list[PlanSettings]:
    """Plans with more thrust than the best that holds, and less than the next bolder one that is like it otherwise."""
    like = [
        point.plan_settings.thrust
        for point in points
        if replace(point.plan_settings, thrust=1.0) == replace(best.plan_settings, thrust=1.0)
    ]
    begin = best.plan_settings.thrust
    bolder = min((thrust for thrust in like if thrust > begin), default=None)
    if bolder is None:
        return []
    return [replace(best.plan_settings, thrust=begin * (bolder / begin) ** way) for way in NARROWED]


def _point(plan_settings: PlanSettings, result: Mapping[str, Any]) -> Point:
    """What was found of a plan."""
    stands = Standing(result["severity"], result["nominal"], tuple(result["rates"]), result["lap"])
    return Point(plan_settings, result["lap"], stands, tuple(map(tuple, result["parameters"])), result["planned"])


def soonest(points: Iterable[Point]) -> Point | None:
    """The fastest that stands all that was asked for; None where none does."""
    return min((point for point in points if point.holds), key=lambda point: point.lap, default=None)


def front(points: Iterable[Point]) -> list[Point]:
    """The points that hold without conditions and that no faster one equals in what it stands, the soonest first.

    Of laps that are equal to a millisecond, by which they are told apart, the one that stands most.
    """
    chosen: list[Point] = []
    most = -math.inf
    for point in sorted(points, key=lambda point: (round(point.lap, 3), -point.standing.severity)):
        if point.standing.severity > max(most, FALLS):
            chosen.append(point)
            most = point.standing.severity
    return chosen


def winner(
    race: Race, tuner: str, settings: TuningSettings, conditions: tuple[Condition, ...], points: Iterable[Point], judge: Do
) -> tuple[Point | None, list[Point]]:
    """The soonest plan that stands all that was asked for in flights that it was not chosen by, and all plans with what these found.

    Args:
        race: as for `search`.
        tuner: likewise.
        settings: likewise; as many flights under each condition as its validation has.
        conditions: likewise.
        points: what was tried.
        judge: works trials off, by keys, and gives what `judge_under_conditions` finds of each.
    """
    known = sorted(points, key=lambda point: point.lap)
    for i, point in enumerate(known):
        if not point.holds:
            continue
        key = f"{point.plan_settings.key}, once more"
        trial = Trial(race, point.plan_settings, tuner, settings, parameters=point.parameters, conditions=conditions)
        again = judge({key: trial})[key]
        stands = Standing(again["severity"], again["nominal"], tuple(again["rates"]), again["lap"])
        known[i] = replace(point, lap=again["lap"] or point.lap, standing=stands)
        if known[i].holds:
            return known[i], known
    return None, known
