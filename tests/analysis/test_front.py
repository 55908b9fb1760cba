"""The search for the fastest plan that holds under conditions, on formulas in place of plans and flights."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from fake_world import OPTIMUM, FakeWorld, make_scenario
from hotlap.analysis import front as search
from hotlap.analysis.front import Point, front, soonest, winner
from hotlap.analysis.plan_trials import PlanSettings, first_plan_settings, most_thrust
from hotlap.analysis.severity import FALLS, SEVERITIES, Standing, standing
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.files.descriptions import load_race
from hotlap.race.conditions import SCALED, UNCHANGED, Change, Condition, Quantity
from hotlap.race.hold import parse_hold
from hotlap.race.vehicle_parameters import VEHICLE_PARAMETERS, check_vehicle_parameters, vehicle_parameters_of
from hotlap.tuning.loop import TuningSettings
from hotlap.tuning.under_conditions import UnderConditions, fly_under

RACE, SETTINGS = load_race("circle-20"), TuningSettings(budget=60, validation=40)
CONDITIONS = parse_hold("mass=+-10%, wind=2")


def formula(limit: float):
    """Laps get shorter with thrust and tolerance; what is stood falls with both, from 2 down to nothing."""
    tried: list[PlanSettings] = []

    def severity_of(plan: PlanSettings) -> float:
        room = limit - math.log(plan.thrust) - 0.1 * math.log(plan.tolerance)
        return FALLS if room < -0.1 else max(level for level in SEVERITIES if level <= max(1 + 5 * room, 0))

    def do(trials):
        tried.extend(trial.plan_settings for trial in trials.values())
        return {key: answer(trial.plan_settings) for key, trial in trials.items()}

    def answer(plan: PlanSettings):
        lap, stands = 10 - math.log(plan.thrust) - 0.05 * math.log(plan.tolerance), severity_of(plan)
        rates = [1.0 if stands >= 1 else 0.5] * len(CONDITIONS)
        return {"lap": lap, "planned": lap, "severity": stands, "nominal": float(stands > FALLS), "rates": rates, "parameters": [[1.0] * 5]}

    return do, tried


def test_it_narrows_the_thrust_down_to_the_boldest_that_stands_all():
    do, tried = formula(limit=-0.05)
    best = soonest(search.search(RACE, "guided_walk", SETTINGS, CONDITIONS, do))
    assert best.standing.severity >= 1
    assert 0.03 > -0.05 - math.log(best.plan_settings.thrust) - 0.1 * math.log(best.plan_settings.tolerance) >= 0
    assert len(tried) == len(set(tried)), "nothing is tried twice"
    assert len(tried) < 25


def test_the_front_has_no_plan_that_another_beats():
    do, _ = formula(limit=-0.1)
    points = search.search(RACE, "guided_walk", SETTINGS, CONDITIONS, do)
    stair = front(points)
    assert [one.lap for one in stair] == sorted(one.lap for one in stair)
    assert [one.standing.severity for one in stair] == sorted({one.standing.severity for one in stair})
    for point in points:
        if point.standing.severity > FALLS:
            assert any(one.lap <= point.lap and one.standing.severity >= point.standing.severity for one in stair)


def test_where_no_plan_can_be_made_nothing_is_found():
    assert search.search(RACE, "guided_walk", SETTINGS, CONDITIONS, lambda trials: {key: {"reason": "no plan"} for key in trials}) == []


def test_plans_of_the_ladder_ask_for_no_more_than_there_is_and_can_hover():
    thrusts = [plan.thrust for plan in search.ladder(RACE)]
    assert max(thrusts) == pytest.approx(most_thrust(RACE))
    assert thrusts == sorted(thrusts, reverse=True)
    for plan in search.ladder(RACE):
        model = plan.applied(RACE).planning_model
        assert model.max_acceleration > 1.15 * model.gravity


def point(lap: float, severity: float) -> Point:
    settings = replace(first_plan_settings(RACE), thrust=lap)
    return Point(settings, lap, Standing(severity, 1.0, (1.0,) * len(CONDITIONS), lap), ((1.0,) * 5,), lap)


def test_what_was_chosen_by_luck_gives_way_to_the_next():
    points = [point(2.0, 0.5), point(3.0, 1.0), point(4.0, 2.0)]

    def judge(trials):
        (key, trial), *_ = trials.items()
        severity = 0.75 if trial.plan_settings.thrust == 3.0 else 1.0
        return {key: {"lap": 4.1, "severity": severity, "nominal": 1.0, "rates": [0.97] * len(CONDITIONS)}}

    best, known = winner(RACE, "guided_walk", SETTINGS, CONDITIONS, points, judge)
    assert (best.plan_settings.thrust, best.lap) == (4.0, 4.1)
    assert best in known
    assert [one.standing.severity for one in known] == [0.5, 0.75, 1.0], "what was luck is known for it"
    assert winner(RACE, "guided_walk", SETTINGS, CONDITIONS, points[:2], judge)[0] is None


class Scales:
    """A world in which all gates are passed while the vehicle is lighter than a limit [kg] and the steady wind below another."""

    name, takes_vehicle_parameters = "scales", True

    def __init__(self, mass: float, wind: float = math.inf) -> None:
        self.mass, self.wind, self.world = mass, wind, FakeWorld(noise=0.0)

    def fly(self, scenario, parameters, seeds, *, vehicle_parameters=None):
        good = vehicle_parameters[:, VEHICLE_PARAMETERS.index("mass")] < self.mass
        good &= scenario.race.noise.steady_wind < self.wind
        values = np.where(good[:, None, None], OPTIMUM, 50 * OPTIMUM)
        return self.world.fly(scenario, np.broadcast_to(values, parameters.shape), seeds)


SCENARIO, SEEDS = make_scenario(), flight_seeds(0, Stream.DEMONSTRATION, 0, 4)
PARAMETERS = np.tile(OPTIMUM, (2, 1))


@pytest.mark.parametrize(
    ("limit", "stands"), [(0.9, FALLS), (1.01, 0.0), (1.06, 0.5), (1.09, 0.75), (1.11, 1.0), (1.19, 1.75), (1.21, 2.0), (9.0, 2.0)]
)
def test_parameters_stand_as_much_as_all_that_is_less_severe_can_be_flown(limit, stands):
    found = standing(SCENARIO, Scales(limit), PARAMETERS, parse_hold("mass=+10%"), SEEDS, 0.95)
    assert found.severity == stands
    assert found.nominal == float(limit > 1)
    assert found.rates == (float(limit > 1.1),)


def test_the_condition_that_is_hardest_to_bear_decides():
    found = standing(SCENARIO, Scales(9.0, wind=2.1), PARAMETERS, parse_hold("mass=+10%, wind=4"), SEEDS, 0.95)
    assert (found.severity, found.rates) == (0.5, (1.0, 0.0))


def test_flights_of_different_conditions_keep_their_order():
    conditions = [*parse_hold("mass=+30%, wind=9, mass=-30%"), UNCHANGED]
    scores = fly_under(SCENARIO, Scales(1.1, wind=3), np.tile(PARAMETERS, (4, 1, 1)), SEEDS, conditions)
    assert scores.complete.tolist() == [False, False, True, True]


def test_as_many_flights_as_there_are_conditions_meet_each_of_them_once():
    objective = UnderConditions(SCENARIO, Scales(1.1, wind=3), conditions=(UNCHANGED, *parse_hold("mass=+30%, wind=9")))
    for first in range(3):
        seeds = flight_seeds(5, Stream.SEARCH, 3 * first, 3)
        assert objective.fly(np.tile(PARAMETERS, (3, 1, 1)), seeds).complete.sum() == 1
    assert objective.flights == 9


@pytest.mark.parametrize("quantity", list(Quantity))
def test_a_condition_of_no_severity_is_none_and_one_of_full_severity_itself(quantity):
    condition = Condition((Change(quantity, 2.0 if quantity is Quantity.NOISE else 0.2),))
    rows, noise = vehicle_parameters_of(RACE.vehicle), RACE.noise
    assert condition.scaled(1.0).changes[0].amount == pytest.approx(condition.changes[0].amount)
    assert condition.scaled(0.0).vehicle_parameters(rows) == pytest.approx(rows)
    assert condition.scaled(0.0).noise(noise).model_dump() == pytest.approx({**noise.model_dump(), "wind": 0.0, "steady_wind": 0.0})


@pytest.mark.parametrize("quantity", list(SCALED))
def test_nothing_gets_lost_altogether_however_severe_it_becomes(quantity):
    rows = Condition((Change(quantity, -0.8),)).scaled(2.0).vehicle_parameters(vehicle_parameters_of(RACE.vehicle))
    check_vehicle_parameters(rows[None])
