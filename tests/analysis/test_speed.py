"""Rates are steps and flights over the time that they took: on a machine whose speed is known, exactly that speed."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from hotlap.analysis import speed
from hotlap.flight.fly import Effort
from hotlap.flight.numbers import Numbers
from hotlap.planning.preparation import prepare

STEP = {Numbers.FLOAT64: 8e-6, Numbers.FLOAT32X8: 2e-6}  # s
STEPS = 1000  # of each flight


def gain(threads: int) -> float:
    """Of several threads over one; a quarter is lost."""
    return 1.0 if threads == 1 else 0.75 * threads


class Machine:
    """Flies each flight in a known time, and has clocks that say so."""

    def __init__(self) -> None:
        self.processor, self.wall, self.compiled = 0.0, 0.0, set()

    def fly(self, _scenario, parameters, _seeds, *, numbers, threads):
        if numbers not in self.compiled:  # the first flight of a kind takes a minute more
            self.compiled.add(numbers)
            self.processor, self.wall = self.processor + 60.0, self.wall + 60.0
        steps = STEPS * len(parameters)
        self.processor += steps * STEP[numbers]
        self.wall += steps * STEP[numbers] / gain(threads)
        return None, Effort(lane_steps=2 * steps, useful_steps=steps)


@pytest.fixture(scope="module")
def measured():
    with pytest.MonkeyPatch.context() as patch:
        machine, said = Machine(), []
        patch.setattr(speed, "fly_batch", machine.fly)
        patch.setattr(speed, "time", SimpleNamespace(process_time=lambda: machine.processor, perf_counter=lambda: machine.wall))
        patch.setattr(speed, "best_numbers", lambda: Numbers.FLOAT32X8)
        return speed.measure(said.append), said


def test_it_says_what_it_does(measured):
    assert len(measured[1]) == speed.STAGES
    assert [line.split()[0] for line in measured[1]] == ["compiling", "compiling", "measuring", "measuring", "measuring", "measuring"]


def test_rates_are_those_of_the_machine_once_it_has_compiled(measured):
    result = measured[0]
    assert result.control_steps_per_second == pytest.approx({"float64": 125_000, "lanes": 500_000})
    assert (result.microseconds_per_step, result.gain) == pytest.approx((2.0, 4.0))
    assert result.real_time_factor == pytest.approx(5000), "steps of 10 ms in 2 us"
    assert result.flights_per_second == pytest.approx(500 * gain(result.threads))
    assert (result.scaling, result.useful_lane_share) == pytest.approx((gain(result.threads), 0.5))
    assert result.lanes == "float32x8"


def test_it_is_told_to_people_and_programs(measured):
    result = measured[0]
    document, lines = result.dump(), result.lines()
    assert set(document) >= {"machine", "threads", "lanes", "control_steps_per_second", "microseconds_per_step", "real_time_factor"}
    assert lines[0].startswith(speed.machine_name())
    assert f"{result.control_steps_per_second['float64']:,.0f}" in lines[1]
    assert all(len(line) <= 140 for line in lines[1:])


def test_real_flights_can_be_measured(monkeypatch):
    for name, value in {"LANE_FLIGHTS": 16, "SCALAR_FLIGHTS": 2, "RANDOM_FLIGHTS": 20, "REPEATS": 1}.items():
        monkeypatch.setattr(speed, name, value)
    result = speed.measure(lambda _: None)
    assert 0 < result.useful_lane_share < 1, "of random parameters, some end early"
    assert min(*result.control_steps_per_second.values(), result.flights_per_second, result.scaling) > 0


def test_parameters_are_scattered_within_their_bounds():
    scenario = prepare(speed.RACE)
    scattered = speed._scatter(scenario, np.random.default_rng(0))
    assert (scattered >= scenario.space.low).all()
    assert (scattered <= scenario.space.high).all()
    assert len(np.unique(scattered[:, 0], axis=0)) == speed.LANE_FLIGHTS


def test_the_machine_has_a_name():
    assert speed.machine_name()
