"""Fastest: the plan of shortest lap time that can be flown reliably, and the controller parameters that fly it.

The reference is a function of time, so the parameters alone hardly change the lap time. An outer search varies the settings of the
planner (v_max, the tolerance at the gates, the thrust it may use), and each plan is tuned. A faster plan leaves less thrust for feedback;
wanted is the fastest that is still reliable. Compass search (Kolda, Lewis, Torczon, SIAM Review 45, 2003): from the best plan so far one
step up and down along each axis, in logarithms; the best reliable one is the next centre, and if there is none, the steps are halved.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap import tuners
from hotlap.analysis.learning import built_in_world
from hotlap.core.errors import HotlapError
from hotlap.core.parameters import Parameters
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.first_guess.guess import first_guess
from hotlap.first_guess.training_set import shipped
from hotlap.planning.preparation import prepare
from hotlap.race.race import Race
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune_together
from hotlap.tuning.objective import Objective

RELIABLE = 0.95  # least validated rate
STEPS = {"v_max": 0.3, "tolerance": 0.5, "thrust": 0.05}  # first ones, in natural logarithms
HALVINGS = 3  # of the steps, before it ends
NEAREST_GATE = 0.9  # share of the judge's distance that a plan may pass a gate at
WIDEST, FASTEST = 5.0, 200.0  # m and m/s, that a race may be planned with
FULL = 0.95  # share of the controller's largest thrust that a plan may use, as where a race does not say
GAIN = 1e-3  # least share by which a lap must be shorter to go on from there
CHOSEN, FRESH = 500_000, 600_000  # first of the flights that plans are ranked by, and of those that the winner is judged by again


Do = Callable[[Mapping[str, "Trial"]], Mapping[str, dict[str, Any]]]


@dataclass(frozen=True)
class PlanSettings:
    """Settings of the planner that the search varies.

    Attributes:
        v_max: [m/s] of its drag; None where the race does not say.
        tolerance: [m] how far from a gate it may pass.
        thrust: factor on the largest rotor thrust that it may plan with.
    """

    v_max: float | None
    tolerance: float
    thrust: float = 1.0

    @property
    def key(self) -> str:
        """Rounded values: a step up and the same step down give the same key."""
        return f"v_max {'-' if self.v_max is None else f'{self.v_max:.4g}'}, tolerance {self.tolerance:.4g}, thrust {self.thrust:.4g}"

    def moved(self, axis: str, factor: float) -> PlanSettings:
        """The same with one setting multiplied."""
        return replace(self, **{axis: getattr(self, axis) * factor})

    def applied(self, race: Race) -> Race:
        """The race, to be planned with these settings."""
        planned = race.planning_model
        low, high = planned.rotor_thrust
        stronger = planned.model_copy(update={"rotor_thrust": (low, high * self.thrust)})
        planning = race.planning.model_copy(update={"v_max": self.v_max, "tolerance": self.tolerance, "quadrotor": stronger})
        return race.model_copy(update={"planning": planning})


@dataclass(frozen=True)
class Trial:
    """A plan to be tuned, or judged.

    Attributes:
        race: what is flown, with its own planning.
        plan_settings: what is planned with.
        tuner: algorithm with preset.
        settings: of the tuning; the plan is judged by as many flights again as its validation has.
        begin: K parameters of the first guess, the mean over segments of those of the best plan so far; None for the learned guess.
        parameters: of each segment, to be judged; empty while they are looked for.
        training: fingerprint of what the guess is learnt from.
    """

    race: Race
    plan_settings: PlanSettings
    tuner: str
    settings: TuningSettings
    begin: tuple[float, ...] | None = None
    parameters: tuple[tuple[float, ...], ...] = ()
    training: str = field(default_factory=lambda: shipped().fingerprint)


def first_plan_settings(race: Race) -> PlanSettings:
    """The planner settings that the race has."""
    return PlanSettings(race.planning.v_max, race.planning.tolerance)


def neighbours(race: Race, centre: PlanSettings, shrunk: float) -> list[PlanSettings]:
    """A step both ways along each axis, as far as the gates and the vehicle allow."""
    most = min(race.vehicle.max_acceleration, FULL * race.controller.thrust[1]) / race.planning_model.max_acceleration
    low, high = race.planning_model.rotor_thrust
    found = []
    for axis, step in STEPS.items():
        if getattr(centre, axis) is None:
            continue
        for sign in (1, -1):
            moved = centre.moved(axis, math.exp(sign * step * shrunk))
            nearest = min(NEAREST_GATE * race.judge.distance, WIDEST)
            moved = replace(moved, tolerance=min(moved.tolerance, nearest), thrust=min(moved.thrust, max(most, 1.0)))
            if moved.v_max is not None:
                moved = replace(moved, v_max=min(moved.v_max, FASTEST))
            if moved.key != centre.key and low < high * moved.thrust:
                found.append(moved)
    return found


def try_plan(trial: Trial) -> Iterator[dict[str, Any]]:
    """Plan, tune and validate: lap [s] as flown, validated rate, parameters; a reason where there is no plan."""
    try:
        scenario = scenario_for(prepare(trial.plan_settings.applied(trial.race)), tuners.build(trial.tuner))
    except HotlapError as error:
        yield {"lap": None, "rate": 0.0, "planned": None, "flights": 0, "parameters": None, "reason": str(error)}
        return
    count = len(scenario.segments)
    guess = first_guess(scenario) if trial.begin is None else np.tile(trial.begin, (count, 1))
    tuning = Tuning(tuners.build(trial.tuner), scenario, trial.settings, guess)
    objective = Objective(scenario, built_in_world())
    for _ in tune_together(objective, [tuning]):
        pass
    assert tuning.best is not None  # noqa: S101  it has flown
    best = tuning.best.parameters
    seeds = flight_seeds(trial.settings.seed, Stream.DEMONSTRATION, CHOSEN, max(trial.settings.validation, 1))
    rate, lap = _flown(objective, best, seeds)
    planned = scenario.reference.lap_time
    yield {"lap": lap, "rate": rate, "planned": planned, "flights": tuning.flights, "parameters": best.tolist(), "reason": ""}


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


def is_reliable(result: dict[str, Any]) -> bool:
    """Whether enough flights of a plan have passed every gate."""
    return result["lap"] is not None and result["rate"] >= RELIABLE


def best_of(results: Sequence[tuple[PlanSettings, dict[str, Any]]]) -> tuple[PlanSettings, dict[str, Any]] | None:
    """The reliable plan of shortest lap time; the first among equals."""
    good = [pair for pair in results if is_reliable(pair[1])]
    return min(good, key=lambda pair: pair[1]["lap"]) if good else None


def fastest(
    race: Race, tuner: str, settings: TuningSettings, do: Do, judge: Do, most_rounds: int = 40
) -> tuple[PlanSettings, dict[str, Any]] | None:
    """The search: the best plan settings, with what was found by them; None where no plan can be flown reliably.

    Args:
        race: its planning is where the search begins; where that cannot be flown, slower plans come first.
        tuner: algorithm with preset.
        settings: of each tuning.
        do: tunes plans, by keys, and gives what `try_plan` finds of each.
        judge: flies plans again, by keys, and gives what `judge_plan` finds of each. The fastest of many is partly chosen by luck, so the
            winner is the fastest that is reliable in these flights too.
        most_rounds: of trials, before it ends.
    """
    centre, shrunk, best, nearest = first_plan_settings(race), 1.0, None, (-1.0, -1.0)
    ranked: list[tuple[PlanSettings, dict[str, Any]]] = []
    trials, tried = {centre.key: Trial(race, centre, tuner, settings)}, {centre.key}
    for _ in range(most_rounds):
        done = do(trials)
        results = [(trial.plan_settings, done[key]) for key, trial in trials.items()]
        found, moved = best_of(results), False
        ranked += [pair for pair in results if is_reliable(pair[1])]
        if found and (best is None or found[1]["lap"] < (1 - GAIN) * best[1]["lap"]):
            best, centre, moved = found, found[0], True
        elif best is None:
            for plan_settings, result in results:
                near = result["rate"], result["planned"] or 0.0  # where none is reliable, the most successful, then the slowest
                if near > nearest:
                    nearest, centre, moved = near, plan_settings, True
        if not moved:
            shrunk /= 2
        if shrunk < 2.0**-HALVINGS:
            break
        begin = None if best is None else tuple(np.exp(np.log(best[1]["parameters"]).mean(axis=0)).tolist())
        around = [plan_settings for plan_settings in neighbours(race, centre, shrunk) if plan_settings.key not in tried]
        trials = {
            f"{plan_settings.key}, after {centre.key}": Trial(race, plan_settings, tuner, settings, begin) for plan_settings in around
        }
        tried |= {plan_settings.key for plan_settings in around}
    return _first_reliable(race, tuner, settings, sorted(ranked, key=lambda pair: pair[1]["lap"]), judge)


def _first_reliable(
    race: Race, tuner: str, settings: TuningSettings, ranked: Sequence[tuple[PlanSettings, dict[str, Any]]], judge: Do
) -> tuple[PlanSettings, dict[str, Any]] | None:
    """The first that is reliable in other flights too, with what was found by these."""
    for plan_settings, result in ranked:
        key = f"{plan_settings.key}, once more"
        again = judge({key: Trial(race, plan_settings, tuner, settings, parameters=tuple(map(tuple, result["parameters"])))})[key]
        if is_reliable(again):
            return plan_settings, {**result, **again}
    return None
