"""A steady wind and a battery that sags act as their files say; without them every flight is the same, bit for bit."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.core.records import Flights, Log
from hotlap.race.battery import Battery
from hotlap.race.vehicle_parameters import VEHICLE_PARAMETERS, vehicle_parameters_of

from .scenarios import GATE_TIMES, GRAVITY, QUIET, fly, make_scenario

NOISE = {"thrust": 0.02, "rates": 0.1, "thrust_bias": 0.01, "position": 0.05, "velocity": 0.05, "attitude": 0.01}
HARDLY = 1e-30  # so little that no float can tell, but not nothing
TIGHT = {"distance": 0.35}


def assert_same(one: Flights, other: Flights) -> None:
    for name in ("gates_passed", "end_time", "end_position", "clock_distance", "mean_error", "max_error"):
        assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


def logs(flights: int, **noise: float) -> list[Log]:
    """Logs of whole flights of quiet air but for what is asked for."""
    flown = fly(make_scenario(noise={**QUIET, **noise}), flights, numbers="float64", log=range(flights))
    return [flown.logs[i] for i in range(flights)]


@pytest.mark.parametrize("gusts", [0.0, 1.0])
def test_a_wind_that_is_no_wind_changes_no_bit(gusts):
    still = fly(make_scenario(noise={**NOISE, "wind": gusts}, judge=TIGHT), 16)
    assert_same(fly(make_scenario(noise={**NOISE, "wind": gusts, "steady_wind": HARDLY}, judge=TIGHT), 16), still)


def test_a_battery_that_gives_all_changes_no_bit_and_one_that_sags_is_felt_by_its_own_flight_alone():
    scenario = make_scenario(noise=NOISE, judge=TIGHT)
    rows = np.tile(vehicle_parameters_of(scenario.race.vehicle), (16, 1))
    rows[5, VEHICLE_PARAMETERS.index("sag")] = 0.2
    full, mixed = fly(scenario, 16), fly(scenario, 16, vehicle_parameters=rows)
    others = np.delete(np.arange(16), 5)
    assert_array_equal(mixed.mean_error[others], full.mean_error[others])
    assert mixed.mean_error[5] > 1.05 * full.mean_error[5]


def test_a_steady_wind_carries_a_drone_away_by_half_the_acceleration_times_time_squared():
    """Within the first period: the controller has not seen it yet."""
    drift = [one.states[1, :3] - logs(1)[0].states[1, :3] for one in logs(3, steady_wind=3.0)]
    assert_allclose(np.linalg.norm(drift, axis=1), 3.0 * 0.01**2 / 2, rtol=1e-6)


def test_a_steady_wind_is_level_lasts_the_flight_and_comes_from_anywhere():
    pushed = np.array([one.states[1, 7:10] for one in logs(400, steady_wind=3.0)]) - logs(1)[0].states[1, 7:10]
    assert_allclose(pushed[:, 2], 0.0, atol=1e-9)
    assert_allclose(np.linalg.norm(pushed, axis=1), 0.03, rtol=1e-6)
    assert np.abs(pushed.mean(axis=0)).max() < 0.03 * 4 / np.sqrt(400)
    angles = np.histogram(np.arctan2(pushed[:, 1], pushed[:, 0]), bins=4, range=(-np.pi, np.pi))[0]
    assert angles.min() > 70, "a hundred in each quarter, but for chance"
    (alone,) = logs(1, steady_wind=3.0)
    end, start = unexplained(alone)[-20:].mean(axis=0), unexplained(alone)[:20].mean(axis=0)
    assert_allclose(end, start, atol=0.2)
    assert_allclose(np.linalg.norm(end[:2]), 3.0, atol=0.2)


def unexplained(log: Log) -> np.ndarray:
    """[m/s^2] acceleration that rotors and gravity do not explain, in each period."""
    scenario = make_scenario()
    q = log.states[:, 3:7].T
    axes = np.array([2 * (q[1] * q[3] + q[0] * q[2]), 2 * (q[2] * q[3] - q[0] * q[1]), 1 - 2 * (q[1] ** 2 + q[2] ** 2)]).T
    thrust = log.rotor_thrusts.sum(axis=1)[:, None] * axes / scenario.race.vehicle.mass
    return np.diff(log.states[:, 7:10], axis=0) / 0.01 - (thrust[1:] + thrust[:-1]) / 2 + [0, 0, GRAVITY]


def given(log: Log) -> np.ndarray:
    """Share of the rotors' thrust that acts, in each period."""
    wanted = log.rotor_thrusts.sum(axis=1) / make_scenario().race.vehicle.mass
    acting = np.linalg.norm(np.diff(log.states[:, 7:10], axis=0) / 0.01 + [0, 0, GRAVITY], axis=1)
    return acting / ((wanted[1:] + wanted[:-1]) / 2)


def sagging(**battery: float) -> Log:
    """The log of a flight with a battery."""
    return fly(make_scenario({"battery": Battery(**battery)}), 1, numbers="float64", log=[0]).logs[0]


def test_a_sag_takes_its_share_of_thrust_by_the_end_of_the_reference_evenly():
    log = sagging(sag=0.2)
    middle = log.times[:-1] + 0.005
    assert_allclose(given(log), 1 - 0.2 * np.minimum(middle / GATE_TIMES[-1], 1.0), atol=0.006)


def test_after_the_end_of_the_reference_nothing_more_is_lost():
    scenario = make_scenario({"battery": Battery(sag=0.2)}, judge={"rule": "closest", "distance": 1e-9, "fly_on": True})
    log = fly(scenario, 1, numbers="float64", log=[0]).logs[0]
    assert log.times[-1] > GATE_TIMES[-1] + 0.5
    assert_allclose(given(log)[-30:], 0.8, atol=0.006)


def test_a_charge_is_counted_by_the_power_of_three_halves_of_the_thrust():
    log = sagging(sag_per_ampere_hour=6.0, hover_current=20.0)
    weight = make_scenario().race.vehicle.mass * GRAVITY
    current = 20.0 * (log.rotor_thrusts.sum(axis=1) / weight) ** 1.5
    charge = np.concatenate([[0.0], np.cumsum(current[:-1]) * 0.01])[:-1] / 3600
    assert 0.1 < 6.0 * charge[-1] < 0.8
    assert_allclose(given(log), 1 - 6.0 * charge, atol=0.01)


def test_a_battery_of_the_race_and_one_of_a_flight_are_the_same_flight():
    battery = Battery(sag=0.1, sag_per_ampere_hour=1.0, hover_current=10.0)
    scenario, plain = make_scenario({"battery": battery}, noise=NOISE), make_scenario(noise=NOISE)
    rows = np.tile(vehicle_parameters_of(scenario.race.vehicle), (4, 1))
    assert_same(fly(plain, 4, vehicle_parameters=rows), fly(scenario, 4))


def test_no_battery_takes_more_than_it_may():
    """A drone whose battery is empty falls: a result, no fault."""
    scenario = make_scenario({"battery": Battery(sag_per_ampere_hour=1e6, hover_current=100.0)})
    flown = fly(scenario, 4)
    assert (flown.gates_passed < 5).all()
    assert np.isfinite(flown.mean_error).all()
