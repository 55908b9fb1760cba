"""What every world keeps to."""

import numpy as np
import pytest

from flight.courses import make_course, parameters
from hotlap import worlds
from hotlap.errors import UnknownNameError

COURSE = make_course(noise={"position": 0.05, "rates": 0.1})
EVERY = pytest.mark.parametrize("name", worlds.names())


@EVERY
def test_a_world_has_its_name_and_a_record_for_every_flight(name):
    world = worlds.build(name)
    assert world.name == name
    flights = world.fly(COURSE, parameters(3), np.array([4, 5, 6]), log=[1])
    gates = len(COURSE.reference.gate_times)
    assert flights.seeds.tolist() == [4, 5, 6]
    assert flights.clock_distance.shape == flights.closest_distance.shape == (3, gates)
    assert flights.end_position.shape == (3, 3)
    assert set(flights.logs) == {1}
    np.testing.assert_array_equal(flights.gate_positions, COURSE.race.track.gate_positions)
    np.testing.assert_array_equal(flights.gate_segments, COURSE.gate_segments)


@EVERY
def test_a_flight_depends_on_parameters_and_seed_and_not_on_its_batch(name):
    world = worlds.build(name)
    together = world.fly(COURSE, parameters(3), np.array([4, 5, 6]))
    alone = world.fly(COURSE, parameters(1), np.array([5]))
    assert alone.mean_error[0] == together.mean_error[1] != together.mean_error[0]
    np.testing.assert_array_equal(alone.clock_distance[0], together.clock_distance[1])


def test_an_unknown_world_is_refused_with_those_there_are():
    with pytest.raises(UnknownNameError, match=r"--on: there is no world named 'moon'; available: built-in"):
        worlds.build("moon")
