"""Plan trials: the settings of the planner that a search for the fastest lap varies, and what a plan made with them is worth.

The reference is a function of time, so the controller's parameters alone hardly change the lap time. An outer search varies how bold the
plan is (v_max, the tolerance at the gates or the clearance within them, the thrust it may use), and each plan is tuned.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap import tuners
from hotlap.analysis.learning import built_in_world
from hotlap.core.errors import HotlapError
from hotlap.core.parameters import Parameters
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.core.shown import Shown
from hotlap.first_guess.guess import first_guess, rival_of
from hotlap.first_guess.training_set import shipped
from hotlap.planning.preparation import prepare
from hotlap.race.conditions import Condition
from hotlap.race.gate_plane import plane_of
from hotlap.race.race import Race
from hotlap.race.track import Waypoint
from hotlap.tuners.contest import beginning_at_better
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune_together
from hotlap.tuning.objective import Objective

STEPS = {"v_max": 0.3, "tolerance": 0.5, "clearance": 0.5, "thrust": 0.05}  # first ones, in natural logarithms
NEAREST_GATE = 0.9  # share of the judge's distance that a plan may pass a gate at
WIDEST, FASTEST = 5.0, 200.0  # m and m/s, that a race may be planned with
FULL = 0.95  # share of the controller's largest thrust that a plan may use, as where a race does not say
CHOSEN, FRESH = 500_000, 600_000  # first of the flights that plans are ranked by, and of those that the winner is judged by again


Do = Callable[[Mapping[str, "Trial"]], Mapping[str, dict[str, Any]]]


@dataclass(frozen=True, repr=False)
class PlanSettings(Shown):
    """Settings of the planner that the search varies.

    Attributes:
        v_max: [m/s] of its drag; None where the race does not say.
        tolerance: [m] how far from a gate it may pass.
        thrust: factor on the largest rotor thrust that it may plan with.
        clearance: [m] to frames and obstacles; None: the planner's own choice.
    """

    v_max: float | None
    tolerance: float
    thrust: float = 1.0
    clearance: float | None = None

    @property
    def key(self) -> str:
        """Rounded values: a step up and the same step down give the same key."""
        clearance = "" if self.clearance is None else f", clearance {self.clearance:.4g}"
        top_speed = "-" if self.v_max is None else f"{self.v_max:.4g}"
        return f"v_max {top_speed}, tolerance {self.tolerance:.4g}, thrust {self.thrust:.4g}{clearance}"

    def moved(self, axis: str, factor: float) -> PlanSettings:
        """The same with one setting multiplied."""
        return replace(self, **{axis: getattr(self, axis) * factor})

    def applied(self, race: Race) -> Race:
        """The race, to be planned with these settings."""
        planned = race.planning_model
        low, high = planned.rotor_thrust
        stronger = planned.model_copy(update={"rotor_thrust": (low, high * self.thrust)})
        chosen = {"v_max": self.v_max, "tolerance": self.tolerance, "clearance": self.clearance, "quadrotor": stronger}
        planning = race.planning.model_copy(update=chosen)
        return race.model_copy(update={"planning": planning})


@dataclass(frozen=True)
class Trial:
    """A plan to be tuned, or judged.

    Attributes:
        race: what is flown, with its own planning.
        plan_settings: what is planned with.
        tuner: algorithm with preset.
        settings: of the tuning; the plan is judged by as many flights again as its validation has.
        begin: K parameters of the first guess, the mean over segments of those of the best plan so far; None: as `tune` begins.
        parameters: of each segment, to be judged; empty while they are looked for.
        training: fingerprint of what the guess is learnt from.
        conditions: that the plan is to be held under, for `front`.
    """

    race: Race
    plan_settings: PlanSettings
    tuner: str
    settings: TuningSettings
    begin: tuple[float, ...] | None = None
    parameters: tuple[tuple[float, ...], ...] = ()
    training: str = field(default_factory=lambda: shipped().fingerprint)
    conditions: tuple[Condition, ...] = ()


def first_plan_settings(race: Race) -> PlanSettings:
    """The planner settings that the race has."""
    return PlanSettings(race.planning.v_max, race.planning.tolerance, clearance=race.planning.clearance)


def neighbours(race: Race, centre: PlanSettings, shrunk: float, axes: Collection[str] = tuple(STEPS)) -> list[PlanSettings]:
    """A step both ways along each axis, as far as the gates and the vehicle allow."""
    low, high = race.planning_model.rotor_thrust
    nearest, largest, room = min(NEAREST_GATE * race.judge.distance, WIDEST), most_thrust(race), least_room(race)
    found = []
    for axis in axes:
        for sign in (1, -1) if _matters(axis, race, centre) else ():
            begin = centre if axis != "clearance" or centre.clearance is not None else replace(centre, clearance=room / 2)
            moved = begin.moved(axis, math.exp(sign * STEPS[axis] * shrunk))
            moved = replace(moved, tolerance=min(moved.tolerance, nearest), thrust=min(moved.thrust, largest))
            if moved.v_max is not None:
                moved = replace(moved, v_max=min(moved.v_max, FASTEST))
            if moved.clearance is not None:
                moved = replace(moved, clearance=min(moved.clearance, NEAREST_GATE * room))
            if moved.key != centre.key and low < high * moved.thrust:
                found.append(moved)
    return found


def _matters(axis: str, race: Race, centre: PlanSettings) -> bool:
    """Whether a setting of the planner changes anything in a race."""
    if axis == "tolerance":
        return any(_room(waypoint, race) is None for waypoint in race.track.route)
    if axis == "clearance":
        return 0 < least_room(race) < math.inf
    return getattr(centre, axis) is not None


def most_thrust(race: Race) -> float:
    """The largest factor on the planning model's thrust that vehicle and controller have, at least 1."""
    possible = min(race.vehicle.max_acceleration, FULL * race.controller.thrust[1])
    return max(possible / race.planning_model.max_acceleration, 1.0)


def least_room(race: Race) -> float:
    """[m] The least that an opening of the track leaves to the vehicle on each side; infinite where it has none."""
    rooms = [room for waypoint in race.track.route if (room := _room(waypoint, race)) is not None]
    return min(rooms, default=math.inf)


def _room(waypoint: Waypoint, race: Race) -> float | None:
    """[m] What a gate's opening leaves to the vehicle on each side; None for a point, a ball or an orientation alone."""
    plane = plane_of(waypoint.gate, race.planning.tolerance)
    return plane.room - race.vehicle.outer_radius if plane is not None and plane.solid else None


def try_plan(trial: Trial) -> Iterator[dict[str, Any]]:
    """Plan, tune and validate: lap [s] as flown, validated rate, parameters; a reason where there is no plan."""
    try:
        scenario = scenario_for(prepare(trial.plan_settings.applied(trial.race)), tuners.build(trial.tuner))
    except HotlapError as error:
        yield {"lap": None, "rate": 0.0, "planned": None, "flights": 0, "parameters": None, "reason": str(error)}
        return
    objective = Objective(scenario, built_in_world())
    best, flights = tune_plan(trial, objective)
    seeds = flight_seeds(trial.settings.seed, Stream.DEMONSTRATION, CHOSEN, max(trial.settings.validation, 1))
    rate, lap = _flown(objective, best, seeds)
    planned = scenario.reference.lap_time
    yield {"lap": lap, "rate": rate, "planned": planned, "flights": flights, "parameters": best.tolist(), "reason": ""}


def tune_plan(trial: Trial, objective: Objective) -> tuple[Parameters, int]:
    """The best parameters of a plan's tuning, shape (S, K), and its flights; where `trial.begin` is None it begins as `tune` does.

    Args:
        trial: which tuner, how, and where it begins.
        objective: flies the plan.
    """
    scenario = objective.scenario
    if trial.begin is not None:
        return tune_from(trial.tuner, trial.settings, objective, np.tile(trial.begin, (len(scenario.segments), 1)))
    guess = first_guess(scenario)
    return tune_from(trial.tuner, trial.settings, objective, guess, rival_of(scenario, guess))


def tune_from(
    tuner: str, settings: TuningSettings, objective: Objective, guess: Parameters, rival: Parameters | None = None
) -> tuple[Parameters, int]:
    """The best parameters of a tuning, shape (S, K), and its flights.

    Args:
        tuner: algorithm with preset.
        settings: of the tuning.
        objective: what flies.
        guess: shape (S, K), where the search begins.
        rival: shape (S, K), where it begins if this one flies better.
    """
    tuning = Tuning(beginning_at_better(tuners.build(tuner), rival), objective.scenario, settings, guess)
    for _ in tune_together(objective, [tuning]):
        pass
    assert tuning.best is not None  # noqa: S101  it has flown
    return tuning.best.parameters, tuning.flights


def judge_plan(trial: Trial) -> Iterator[dict[str, Any]]:
    """Fly the winner, K parameters of each segment in `trial.parameters`, with noise other than that it was chosen by."""
    scenario = prepare(trial.plan_settings.applied(trial.race))
    seeds = flight_seeds(trial.settings.seed, Stream.DEMONSTRATION, FRESH, max(trial.settings.validation, 1))
    rate, lap = _flown(Objective(scenario, built_in_world()), np.array(trial.parameters), seeds)
    yield {"lap": lap, "rate": rate}


def _flown(objective: Objective, parameters: Parameters, seeds: NDArray[np.int64]) -> tuple[float, float | None]:
    """Share of flights that pass every gate, and their mean lap [s]."""
    scores = objective.fly(np.repeat(parameters[None], len(seeds), axis=0), seeds)
    return float(scores.complete.mean()), float(np.nanmean(scores.lap_time)) if scores.complete.any() else None
