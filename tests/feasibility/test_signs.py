"""What logs of failed flights show, read from flights of vehicles that are known."""

from __future__ import annotations

import numpy as np
import pytest

from flight.scenarios import TUNED, make_scenario
from hotlap.feasibility.signs import Signs, signs_of
from hotlap.worlds.built_in import BuiltIn

WORLD = BuiltIn(threads=1)


def signs(vehicle: dict | None = None, seconds: float = 3.0, **settings) -> Signs:
    scenario = make_scenario(vehicle, **settings)
    flights = WORLD.fly(scenario, np.tile(TUNED, (1, 2, 1)), np.zeros(1, dtype=np.int64), log=[0])
    found = signs_of(scenario, flights.logs[0], min(seconds, float(flights.end_time[0])))
    assert found is not None
    return found


@pytest.mark.parametrize("factor", [0.85, 1.0, 1.25])
def test_thrust_that_acts_is_read_from_what_was_commanded(factor):
    assert signs({"mass": 0.716 * factor}).effectiveness == pytest.approx(1 / factor, rel=0.03)


@pytest.mark.parametrize("delay", [0.0, 0.04, 0.08])
def test_dead_time_is_read_from_the_answers_of_the_rates(delay):
    assert signs({"delay": delay}, noise={"position": 0.1}).dead_time == pytest.approx(delay, abs=0.03)


def test_thrust_at_its_limit_is_seen():
    assert signs().saturated == 0
    assert signs(controller={"thrust": (0.1, 12.0)}).saturated > 0.5


def test_a_drone_that_lags_is_behind_and_one_that_sinks_is_not():
    assert signs({"drag": (0.3, 0.3, 0.3)}, seconds=1.4).behind
    assert signs({"mass": 1.0}, seconds=1.0).above < 0


def test_a_flight_that_ends_at_once_shows_nothing():
    scenario = make_scenario()
    flights = WORLD.fly(scenario, np.tile(TUNED, (1, 2, 1)), np.zeros(1, dtype=np.int64), log=[0])
    assert signs_of(scenario, flights.logs[0], 0.05) is None
