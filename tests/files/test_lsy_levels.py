"""The levels of lsy_drone_racing as races: level 1 is level 0 with a drone that nobody knows exactly."""

import numpy as np
import pytest

from hotlap.core.records import End
from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare
from hotlap.worlds.built_in import BuiltIn

UNIFORM = 1 / np.sqrt(3)  # standard deviation of what is drawn evenly from -1 to 1


def test_level_1_is_level_0_but_for_its_noise():
    zero, one = (load_race(f"lsy-level{level}") for level in (0, 1))
    assert one.model_copy(update={"noise": zero.noise, "name": zero.name, "provenance": zero.provenance}) == zero


def test_the_noise_of_level_1_is_as_large_as_what_the_source_draws():
    race = load_race("lsy-level1")
    noise, mass = race.noise, race.vehicle.mass
    assert noise.thrust_bias == pytest.approx(0.005 * UNIFORM / mass, rel=0.02)
    assert noise.position == pytest.approx(0.1 * UNIFORM, rel=0.02)
    assert noise.attitude == pytest.approx(0.1 * UNIFORM / 2, rel=0.02)
    drift = 0.1 * UNIFORM / mass * np.sqrt(0.002)  # m/s per root of a second
    assert noise.wind * np.sqrt(2 * noise.wind_time) == pytest.approx(drift, rel=0.05)


@pytest.mark.check
@pytest.mark.parametrize("level", [0, 1])
def test_the_default_weights_finish_most_flights(level):
    scenario = prepare(f"lsy-level{level}")
    first = scenario.space.first_guess(len(scenario.segments))
    flights = BuiltIn().fly(scenario, np.tile(first, (50, 1, 1)), np.arange(50))
    assert (flights.end == End.FINISHED).mean() > 0.5
    assert flights.lap_time[flights.end == End.FINISHED] == pytest.approx(3.17, abs=0.2)
