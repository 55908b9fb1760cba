"""Flights in lanes: a lane that is lost harms no other, and what a race says about noise and dead time is what flies."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.core.records import End, Flights
from hotlap.flight.numbers import Numbers
from hotlap.race.vehicle_parameters import VEHICLE_PARAMETERS, vehicle_parameters_of

from .scenarios import GRAVITY, fly, make_scenario, parameters

DEFAULT = (200.0, 500.0, 50.0, 10.0, 4.0)
RESULTS = ("gates_passed", "end", "end_time", "end_position", "lap_time", "clock_distance", "closest_distance", "mean_error", "max_error")


def vehicles(flights: int, flight: int, **changes: float) -> np.ndarray:
    """The vehicle of the small race, but for one flight."""
    rows = np.tile(vehicle_parameters_of(make_scenario().race.vehicle), (flights, 1))
    for name, factor in changes.items():
        rows[flight, VEHICLE_PARAMETERS.index(name)] *= factor
    return rows


def others_are_the_same(one: Flights, two: Flights, flight: int) -> None:
    for name in RESULTS:
        assert_array_equal(np.delete(getattr(one, name), flight, axis=0), np.delete(getattr(two, name), flight, axis=0), err_msg=name)


@pytest.mark.parametrize("change", [{"mass": 3.0}, {"rate_gain_x": 1e4}, {"inertia_x": 1e-12}, {"mass": 1e-30}])
def test_a_flight_that_is_lost_is_a_crash_or_a_miss_and_harms_no_other(change):
    lost = fly(make_scenario(), 20, vehicle_parameters=vehicles(20, 6, **change))
    assert lost.end[6] != End.FINISHED
    assert lost.gates_passed[6] < 5
    assert np.isfinite([lost.end_time[6], lost.mean_error[6], lost.max_error[6]]).all()
    others_are_the_same(lost, fly(make_scenario(), 20), 6)


@pytest.mark.parametrize("values", [(1e-30,) * 4 + (6.0,), (1e30,) * 4 + (6.0,), (*DEFAULT[:4], 1e-300), (*DEFAULT[:4], 1e300)])
def test_parameters_without_reason_do_no_harm(values):
    asked = parameters(12)
    asked[3, 1] = values
    others_are_the_same(fly(make_scenario(), asked), fly(make_scenario(), 12), 3)


def fly_default(vehicle: dict[str, Any] | None = None, **settings: dict[str, Any]) -> Flights:
    """One flight with the default weights."""
    return fly(make_scenario(vehicle, **settings), parameters(1, DEFAULT))


def error(vehicle: dict[str, Any] | None = None, **settings: dict[str, Any]) -> float:
    return float(fly_default(vehicle, **settings).mean_error[0])


@pytest.mark.parametrize("delay", [0.05, 0.0875, 0.15])
def test_a_dead_time_that_is_known_costs_little(delay):
    """Until the first command arrives, the reference leaves alone."""
    assert error({"delay": delay}, model={"delay": delay}) < error() + 0.3 * delay


def test_a_dead_time_that_is_not_known_costs_much():
    assert error({"delay": 0.05}) > 1.5 * error({"delay": 0.05}, model={"delay": 0.05})
    assert fly_default({"delay": 0.0875}, model={"delay": 0.0875}).end[0] == End.FINISHED
    assert fly_default({"delay": 0.0875}).end[0] == End.MISSED


def test_prediction_can_be_turned_off_or_read_its_reference_now():
    """A reference read now is trailed by about dead time x speed."""
    late = {"delay": 0.05}
    known = error(late, model=late)
    assert error(late, model=late, controller={"predict": False}) == error(late)
    assert 8 * known < error(late, model=late, controller={"reference_time": "now"}) < 0.05 * 7.0


def logged(flights: int, **noise: float) -> np.ndarray:
    """First logged states, shape (flights, 3, 13); a first gate that cannot be hit ends the flights soon."""
    scenario = make_scenario(noise=noise, judge={"distance": 1e-9})
    soon = replace(scenario.reference, gate_times=np.append(0.03, scenario.reference.gate_times[1:]))
    logs = fly(replace(scenario, reference=soon), flights, numbers="float64", log=range(flights)).logs
    return np.array([logs[i].states[:3] for i in range(flights)])


def test_flights_begin_as_scattered_as_the_race_says():
    states = logged(300, position=0.05, velocity=0.2, attitude=0.01)[:, 0] - logged(1)[0, 0]
    for columns, deviation in ((slice(0, 3), 0.05), (slice(4, 7), 0.01), (slice(7, 10), 0.2)):
        assert_allclose(states[:, columns].std(axis=0), deviation, rtol=0.15)
        assert_allclose(states[:, columns].mean(axis=0), 0.0, atol=4 * deviation / np.sqrt(300))
    assert_array_equal(states[:, 10:], np.zeros((300, 3)))


def test_measured_noise_is_not_in_the_state_itself():
    noisy, quiet = logged(5, measured_position=0.1, measured_velocity=0.1, measured_attitude=0.05), logged(1)[0]
    assert_array_equal(noisy[:, 0], np.tile(quiet[0], (5, 1)))
    assert (noisy[:, 1] != quiet[1]).any(axis=1).all()


def test_gusts_push_as_hard_as_the_race_says_and_last():
    """A correlated series of variance 2^2 that begins at 0: its first and second numbers."""
    velocity = logged(300, wind=2.0)[..., 7:10] - logged(1)[0, :, 7:10]
    first, second = np.diff(velocity, axis=1).swapaxes(0, 1) / 0.01
    memory = np.exp(-0.01 / 1.0)
    assert_allclose(first.std(), 2.0 * np.sqrt(1 - memory**2), rtol=0.1)
    assert_allclose(second.std(), 2.0 * np.sqrt(1 - memory**4), rtol=0.1)
    assert_allclose(np.mean(first * second) / np.var(first), memory, rtol=0.1)


def test_a_thrust_bias_lasts_a_flight():
    """Thrust is m g at first: an error of it accelerates."""
    lifts = (logged(300, thrust_bias=0.05)[:, 1, 9] - logged(1)[0, 1, 9]) / 0.01
    assert_allclose(lifts.std(), 0.05 * GRAVITY, rtol=0.15)


@pytest.mark.parametrize("rule", ["closest", "released"])
def test_other_rules_judge_whole_flights(rule):
    """A gate that is too small to be hit ends the flight when nobody can pass it any more; the log reaches as far."""
    scenario = make_scenario(judge={"rule": rule, "distance": 1e-9})
    flown = fly(scenario, 2, log=[0])
    last = scenario.reference.gate_times[0] + 2.0 if rule == "closest" else scenario.reference.gate_times[-1]
    assert_array_equal(flown.end, [End.MISSED] * 2)
    assert_allclose(flown.end_time, last, atol=0.0101)
    assert flown.logs[0].times[-1] == pytest.approx(flown.end_time[0])
    assert np.isfinite(flown.logs[0].states).all()


def test_after_a_miss_a_flight_may_go_on_to_its_end():
    flown = fly(make_scenario(judge={"rule": "clock", "distance": 1e-9, "fly_on": True}))
    assert (flown.end[0], flown.gates_passed[0]) == (End.MISSED, 0)
    assert np.isfinite(flown.clock_distance[0]).all()


@pytest.mark.check
@pytest.mark.parametrize(("numbers", "apart"), [(Numbers.FLOAT64X4, 1e-9), (Numbers.FLOAT32X8, 1e-4), (Numbers.FLOAT32X16, 1e-4)])
def test_every_kind_of_number_flies_the_same(numbers, apart):
    scenario = make_scenario(noise={"position": 0.05, "rates": 0.1})
    expected, found = fly(scenario, 20, numbers="float64"), fly(scenario, 20, numbers=numbers)
    assert_array_equal(found.gates_passed, expected.gates_passed)
    assert_allclose(found.clock_distance, expected.clock_distance, atol=apart)
    assert_allclose(found.mean_error, expected.mean_error, atol=apart)
