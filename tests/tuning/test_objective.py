"""An objective flies and scores under the race's rule, and counts."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest

from fake_world import FakeWorld, make_scenario
from hotlap.core.errors import InputError
from hotlap.race.race import GateRule, JudgeSettings
from hotlap.race.vehicle_parameters import draw_vehicle_parameters
from hotlap.tuning.objective import Objective
from hotlap.tuning.scoring import Metric, score


def test_scores_are_those_of_the_flights_under_the_races_rule_and_the_metric():
    scenario = make_scenario(JudgeSettings(rule=GateRule.RELEASED))
    objective = Objective(scenario, FakeWorld(), Metric.MEAN_ERROR)
    parameters = np.tile(scenario.space.first_guess(2), (6, 1, 1))
    flights, scores = objective.fly_recorded(parameters, np.arange(6))
    np.testing.assert_array_equal(scores.cost, score(flights, scenario.race.judge, Metric.MEAN_ERROR).cost)
    np.testing.assert_array_equal(scores.cost, objective.fly(parameters, np.arange(6)).cost)
    assert not np.array_equal(scores.cost, score(flights, JudgeSettings(), Metric.TIME).cost)


@dataclass
class Remembering(FakeWorld):
    """Remembers in which rows it flew."""

    vehicle_parameters: np.ndarray | None = None

    def fly(self, scenario, parameters, seeds, *, vehicle_parameters=None, log=()):
        self.vehicle_parameters = vehicle_parameters
        return super().fly(scenario, parameters, seeds, log=log)


def test_a_randomised_objective_flies_every_seed_in_a_world_of_its_own():
    scenario, world, seeds = make_scenario(), Remembering(), np.arange(6)
    parameters = np.tile(scenario.space.first_guess(2), (6, 1, 1))
    Objective(scenario, world, randomise=0.2).fly(parameters, seeds)
    np.testing.assert_array_equal(world.vehicle_parameters, draw_vehicle_parameters(scenario.race.vehicle, seeds, 0.2))
    Objective(scenario, world).fly(parameters, seeds)
    assert world.vehicle_parameters is None


def test_flights_are_counted():
    objective = Objective(make_scenario(), FakeWorld())
    parameters = np.tile(objective.scenario.space.first_guess(2), (3, 1, 1))
    objective.fly(parameters, np.arange(3))
    objective.fly_recorded(parameters[:2], np.arange(2))
    assert objective.flights == 5


def near(flights, scores, weight=1.0):  # noqa: ARG001
    return weight * flights.max_error


class Nearest:
    def __call__(self, flights, scores):
        return near(flights, scores)


def test_a_cost_of_ones_own_has_a_name_and_a_digest_of_its_source():
    named = [Objective(make_scenario(), FakeWorld(), cost=cost).own_cost for cost in (near, partial(near, weight=2.0), Nearest())]
    assert re.fullmatch(r"\S*test_objective\.near [0-9a-f]{8}", named[0])
    assert named[1] == named[0]
    assert re.fullmatch(r"\S*test_objective\.Nearest [0-9a-f]{8}", named[2])
    assert Objective(make_scenario(), FakeWorld()).own_cost == ""


def test_a_cost_of_ones_own_takes_the_place_of_both_costs_and_of_nothing_else():
    scenario = make_scenario()
    parameters, seeds = np.tile(scenario.space.first_guess(2), (6, 1, 1)), np.arange(6)
    own = Objective(scenario, FakeWorld(), cost=lambda flights, scores: flights.max_error + scores.completion).fly(parameters, seeds)
    flights, plain = Objective(scenario, FakeWorld()).fly_recorded(parameters, seeds)
    np.testing.assert_array_equal(own.cost, flights.max_error + plain.completion)
    np.testing.assert_array_equal(own.dense, own.cost)
    np.testing.assert_array_equal(own.completion, plain.completion)


@pytest.mark.parametrize("cost", [lambda flights, _: flights.max_error.mean(), lambda flights, _: flights.max_error[:, None]])
def test_a_cost_of_ones_own_is_one_number_a_flight(cost):
    scenario = make_scenario()
    parameters = np.tile(scenario.space.first_guess(2), (6, 1, 1))
    with pytest.raises(InputError, match=r"cost: must return one number for each flight, shape \(6,\), not \("):
        Objective(scenario, FakeWorld(), cost=cost).fly(parameters, np.arange(6))


@pytest.mark.parametrize(
    ("cost", "said"),
    [
        (lambda flights, _: -1.0 - flights.mean_error, "must not be negative, not -"),
        (lambda flights, _: np.full(len(flights), -np.inf), "must not be negative, not -inf"),
        (lambda _flights, _scores: None, "must return one number for each flight, shape (6,), not ()"),
        (lambda _flights, _scores: {"cost": 1}, "must return numbers, shape (6,), not a dict"),
        (lambda flights, _: ["much"] * len(flights), "must return numbers, shape (6,), not a list"),
    ],
)
def test_a_cost_of_ones_own_that_is_negative_or_no_number_is_refused_in_one_line(cost, said):
    scenario = make_scenario()
    parameters = np.tile(scenario.space.first_guess(2), (6, 1, 1))
    with pytest.raises(InputError) as error:
        Objective(scenario, FakeWorld(), cost=cost).fly(parameters, np.arange(6))
    assert str(error.value).startswith(f"cost: {said}")
    assert "\n" not in str(error.value)


def test_a_cost_of_ones_own_that_is_not_finite_is_the_worst():
    scenario = make_scenario()
    parameters = np.tile(scenario.space.first_guess(2), (2, 1, 1))
    costs = Objective(scenario, FakeWorld(), cost=lambda *_: [np.inf, np.nan]).fly(parameters, np.arange(2)).cost
    np.testing.assert_array_equal(costs, [np.inf, np.nan])
