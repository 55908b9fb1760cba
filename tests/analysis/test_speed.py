"""The speed says what it measured, in rates that fit together."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hotlap.analysis import speed
from hotlap.flight.numbers import Numbers
from hotlap.planning.preparation import prepare


@pytest.fixture(scope="module")
def measured():
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {"LANE_FLIGHTS": 16, "SCALAR_FLIGHTS": 2, "RANDOM_FLIGHTS": 20, "REPEATS": 2}.items():
            patch.setattr(speed, name, value)
        patch.setattr(speed, "best_numbers", lambda: Numbers.FLOAT32X8)
        said: list[str] = []
        return speed.measure(said.append), said


def test_it_says_what_it_does(measured):
    assert len(measured[1]) == speed.STAGES
    assert [line.split()[0] for line in measured[1]] == ["compiling", "compiling", "measuring", "measuring", "measuring", "measuring"]


def test_rates_fit_together(measured):
    result = measured[0]
    rate = result.control_steps_per_second["lanes"]
    assert result.lanes == "float32x8"
    assert result.gain == rate / result.control_steps_per_second["float64"] > 1.5
    assert math.isclose(result.microseconds_per_step * rate, 1e6)
    assert math.isclose(result.real_time_factor, 0.01 * rate)
    assert 0 < result.useful_lane_share <= 1
    assert result.scaling > 0 < result.flights_per_second


def test_it_is_told_to_people_and_programs(measured):
    result = measured[0]
    document, lines = result.dump(), result.lines()
    assert set(document) >= {"machine", "threads", "lanes", "control_steps_per_second", "microseconds_per_step", "real_time_factor"}
    assert lines[0].startswith(speed.machine_name())
    assert f"{result.control_steps_per_second['float64']:,.0f}" in lines[1]
    assert all(len(line) <= 140 for line in lines[1:])


def test_parameters_are_scattered_within_their_bounds():
    scenario = prepare(speed.RACE)
    scattered = speed._scatter(scenario, np.random.default_rng(0))
    assert (scattered >= scenario.space.low).all()
    assert (scattered <= scenario.space.high).all()
    assert len(np.unique(scattered[:, 0], axis=0)) == speed.LANE_FLIGHTS


def test_the_machine_has_a_name():
    assert speed.machine_name()
