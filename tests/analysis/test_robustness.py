"""Conditions that a tuned controller is asked to bear."""

import numpy as np

from flight.scenarios import TUNED, make_scenario
from hotlap.analysis.robustness import check_robustness
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.race.conditions import DEFAULT_CONDITIONS, UNCHANGED
from hotlap.race.hold import parse_hold
from hotlap.tuning.goal import Goal
from hotlap.tuning.scoring import score
from hotlap.worlds.built_in import BuiltIn

SCENARIO = make_scenario(noise={"position": 0.05, "thrust": 0.02, "rates": 0.1}, judge={"distance": 0.6})


def test_every_condition_is_flown_as_often_and_the_first_is_none():
    parameters = np.tile(TUNED, (2, 1))
    holds = check_robustness(SCENARIO, BuiltIn(), Goal(), parameters, seed=1, flights=16)
    assert [hold.condition for hold in holds] == [UNCHANGED, *DEFAULT_CONDITIONS]
    assert {hold.validation.flights for hold in holds} == {16}
    assert holds[0].validation.successes == 16
    again = check_robustness(SCENARIO, BuiltIn(), Goal(), parameters, seed=1, flights=16)
    assert holds == again


def test_what_is_hard_to_bear_costs_successes():
    tight = make_scenario(noise={"position": 0.05}, judge={"distance": 0.16})
    world, parameters = BuiltIn(), np.tile(TUNED, (2, 1))
    holds = check_robustness(tight, world, Goal(), parameters, 1, flights=16)
    assert min(hold.validation.rate for hold in holds) < holds[0].validation.rate
    flown = world.fly(tight, np.repeat(parameters[None], 16, axis=0), flight_seeds(1, Stream.DEMONSTRATION, 0, 16))
    assert check_robustness(tight, world, Goal(), parameters, 1, 16, score(flown, tight.race.judge)) == holds


def test_conditions_of_ones_own_are_flown_in_order_whatever_batch_they_share():
    parameters, asked = np.tile(TUNED, (2, 1)), parse_hold("wind=3, mass=+60%, gusts=1, thrust=-50%, wind=3 & mass=+10%")
    holds = check_robustness(SCENARIO, BuiltIn(), Goal(), parameters, 1, 16, asked=asked, further=())
    assert [hold.condition for hold in holds] == [UNCHANGED, *asked]
    alone = [check_robustness(SCENARIO, BuiltIn(), Goal(), parameters, 1, 16, asked=[condition], further=())[1] for condition in asked]
    assert list(holds[1:]) == alone
    rates = {hold.change: hold.validation.rate for hold in holds}
    assert rates["50 % less thrust"] < 1, "nobody flies this circle with half of the thrust"
