"""What every world keeps to."""

import numpy as np
import pytest

from flight.scenarios import make_scenario, parameters
from hotlap import worlds
from hotlap.core.records import End
from hotlap.race.race import GateRule
from hotlap.race.vehicle_parameters import VEHICLE_PARAMETERS, vehicle_parameters_of

SCENARIO = make_scenario(noise={"position": 0.05, "rates": 0.1})
EVERY = pytest.mark.parametrize("name", ["built-in", "worlds.own_simulator.Own"])


@EVERY
def test_a_world_has_its_name_and_a_record_for_every_flight(name):
    world = worlds.build(name)
    assert world.name == name
    flights = world.fly(SCENARIO, parameters(3), np.array([4, 5, 6]), log=[1])
    gates = len(SCENARIO.reference.gate_times)
    assert flights.seeds.tolist() == [4, 5, 6]
    assert flights.clock_distance.shape == flights.closest_distance.shape == (3, gates)
    assert flights.end_position.shape == (3, 3)
    assert set(flights.logs) == {1}
    np.testing.assert_array_equal(flights.gate_positions, SCENARIO.race.track.gate_positions)
    np.testing.assert_array_equal(flights.gate_segments, SCENARIO.gate_segments)


@EVERY
def test_a_flight_depends_on_parameters_and_seed_and_not_on_its_batch(name):
    world = worlds.build(name)
    together = world.fly(SCENARIO, parameters(3), np.array([4, 5, 6]))
    alone = world.fly(SCENARIO, parameters(1), np.array([5]))
    assert alone.mean_error[0] == together.mean_error[1] != together.mean_error[0]
    np.testing.assert_array_equal(alone.clock_distance[0], together.clock_distance[1])


@EVERY
def test_flying_changes_neither_the_world_nor_what_it_is_given(name):
    world, asked, seeds = worlds.build(name), parameters(2), np.array([4, 5])
    first = world.fly(SCENARIO, asked, seeds)
    world.fly(SCENARIO, 2 * asked, seeds + 7)
    again = world.fly(SCENARIO, asked, seeds)
    np.testing.assert_array_equal(first.clock_distance, again.clock_distance)
    np.testing.assert_array_equal(asked, parameters(2))
    np.testing.assert_array_equal(seeds, [4, 5])


def test_other_vehicles_are_flown_in_place_of_the_races_by_a_world_that_takes_them():
    world, vehicle_parameters = worlds.build("built-in"), np.tile(vehicle_parameters_of(SCENARIO.race.vehicle), (2, 1))
    assert world.takes_vehicle_parameters
    vehicle_parameters[1, VEHICLE_PARAMETERS.index("mass")] *= 1.2
    flights = world.fly(SCENARIO, parameters(2), np.array([4, 4]), vehicle_parameters=vehicle_parameters)
    assert flights.mean_error[0] == world.fly(SCENARIO, parameters(1), np.array([4])).mean_error[0]
    assert flights.mean_error[1] != flights.mean_error[0]


@EVERY
def test_the_same_judge_reads_every_rule(name):
    """What a world says was passed is what its own distances say."""
    for rule in GateRule:
        scenario = make_scenario(noise={"position": 0.05, "rates": 0.5}, judge={"rule": rule, "distance": 0.12})
        flights = worlds.build(name).fly(scenario, parameters(12), np.arange(12))
        distance = flights.clock_distance if rule is GateRule.CLOCK else flights.closest_distance
        close = flights.rim_distance <= 0 if rule is GateRule.OPENING else distance < scenario.race.judge.distance
        close[:, -1] |= rule is GateRule.RELEASED
        np.testing.assert_array_equal(flights.gates_passed, np.cumprod(close, axis=1).sum(axis=1))
        np.testing.assert_array_equal(flights.end == End.FINISHED, flights.gates_passed == close.shape[1])
        assert len(set(flights.gates_passed.tolist())) > 1
