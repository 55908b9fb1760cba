"""A drone stands on the ground until it takes off: neither noise at its start nor sagging puts it under the floor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.core.records import Cause, End, Flights
from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare

from .scenarios import fly, make_reference, make_scenario

START = float(make_reference().position[0, 2])  # m
FLIGHTS = 16


def fly_above(floor: float | None, *, thrust_factor: float = 1.0, **noise: float) -> Flights:
    """Fly the small race above a floor, by a vehicle whose rotors give another thrust than it is told."""
    scenario = make_scenario({"mass": load_race("circle-34").vehicle.mass / thrust_factor}, noise=noise)
    track = scenario.race.track.model_copy(update={"floor": floor})
    scenario = replace(scenario, race=scenario.race.model_copy(update={"track": track}))
    return fly(scenario, FLIGHTS, log=range(FLIGHTS))


def heights(flown: Flights) -> list[np.ndarray]:
    return [flown.logs[i].states[:, 2] for i in range(FLIGHTS)]


@pytest.mark.parametrize("below", [0.0, 0.2])
def test_noise_at_the_start_puts_no_drone_under_the_floor(below):
    free, above = (np.array([path[0] for path in heights(fly_above(floor, position=0.3))]) for floor in (None, START - below))
    assert (free < START - below).any()
    assert_allclose(above, np.maximum(free, START - below), atol=1e-6)


def test_a_start_that_lies_under_the_floor_is_not_moved():
    flown = fly_above(START + 0.05)
    assert_array_equal([path[0] for path in heights(flown)], START)


def test_a_drone_that_is_pushed_down_stands_on_the_ground_and_takes_off():
    flown = fly_above(START, velocity=1.0)
    assert (flown.end == End.FINISHED).all()
    assert min(path.min() for path in heights(flown)) == pytest.approx(START, abs=1e-6)
    assert min(path.min() for path in heights(fly_above(None, velocity=1.0))) < START - 0.05


def test_a_drone_on_the_ground_does_not_fall():
    """Whatever pulls it down, its speed on the ground is not negative."""
    flown = fly_above(START, thrust_factor=0.9)
    for path, speed in zip(heights(flown), (flown.logs[i].states[:, 9] for i in range(FLIGHTS)), strict=True):
        standing = path <= np.float32(START)
        assert standing[1:4].all()
        assert (speed[standing] >= 0).all()


def test_after_take_off_the_floor_is_one():
    """A vehicle far too weak for its reference rises, sinks and is stopped by the ground; without a floor it is not."""
    flown = fly_above(START, velocity=1.5, thrust_factor=0.55)
    crashed = flown.cause == Cause.FLOOR
    assert crashed.any()
    assert (flown.end[crashed] == End.CRASHED).all()
    assert all(max(path) > START + 0.1 for path, hit in zip(heights(flown), crashed, strict=True) if hit)


def test_a_race_that_starts_on_the_ground_is_flown_as_if_it_began_in_the_air(tmp_path):
    file = tmp_path / "hop.toml"
    file.write_text("""
        vehicle = "split-s-racer"
        track = { start = [0.0, 0.0, 0.01], floor = 0.0, gates = [[3.0, 0.0, 1.0], [6.0, 2.0, 1.0]] }
    """)
    scenario = prepare(load_race(file))
    default = np.tile(scenario.space.default, (100, len(scenario.segments), 1))
    assert (fly(scenario, default).end == End.FINISHED).all()
