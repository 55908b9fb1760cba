"""A stepped simulator flies as the built-in world does where its physics are the same."""

from __future__ import annotations

from dataclasses import fields
from functools import partial

import numpy as np
import pytest

from flight.scenarios import TUNED, make_scenario, parameters
from hotlap.core.errors import HotlapError, InputError
from hotlap.core.records import Flights
from hotlap.planning.preparation import prepare
from hotlap.race.battery import Battery
from hotlap.race.vehicle_parameters import vehicle_parameters_of
from hotlap.reference.scenario import Scenario
from hotlap.worlds.built_in import BuiltIn
from hotlap.worlds.plant_simulator import PlantSimulator
from hotlap.worlds.simulator import Start
from hotlap.worlds.stepped import Stepped

NOISE = {"thrust": 0.02, "rates": 0.1, "thrust_bias": 0.01, "position": 0.05, "velocity": 0.05, "attitude": 0.01}
NOISY = make_scenario(noise=NOISE, judge={"distance": 0.35})
SEEDS = np.arange(8)
SAME = 1e-6  # m, s: of arithmetic that is compiled twice


def plant(scenario: Scenario, _instance: int, lanes: int = 1) -> PlantSimulator:
    """The built-in world's plant for the vehicle of a race."""
    floor = -np.inf if scenario.race.track.floor is None else scenario.race.track.floor
    return PlantSimulator(scenario.race.vehicle, scenario.race.control_model, floor, lanes)


def assert_same(one: Flights, other: Flights, tolerance: float = 0.0) -> None:
    """Two batches flew the same flights."""
    for field in fields(Flights):
        if field.name != "logs":
            np.testing.assert_allclose(getattr(one, field.name), getattr(other, field.name), rtol=0, atol=tolerance, err_msg=field.name)
    assert one.logs.keys() == other.logs.keys()
    for i, log in one.logs.items():
        for field in fields(log):
            np.testing.assert_allclose(getattr(log, field.name), getattr(other.logs[i], field.name), rtol=0, atol=10 * tolerance)


SIX = tuple((0.17 * np.cos(turn), 0.17 * np.sin(turn), (-1) ** i) for i, turn in enumerate(np.pi / 6 + np.arange(6) * np.pi / 3))


@pytest.mark.check  # each kind of plant is compiled
@pytest.mark.parametrize(
    "vehicle",
    [
        {"mixer": "scale", "rate_delay": 0.0075, "motor_lag": "thrust"},
        {"rotors": SIX, "arm": 0.17, "rotor_thrust": [0.0, 4.0]},
    ],
)
def test_a_detailed_plant_is_flown_as_in_the_built_in_world(vehicle):
    scenario = make_scenario(vehicle, model=vehicle, noise=NOISE, judge={"distance": 0.35})
    flown = Stepped("plant", plant).fly(scenario, parameters(2), SEEDS[:2], log=[0])
    home = BuiltIn("float64", threads=1).fly(scenario, parameters(2), SEEDS[:2], log=[0])
    assert flown.logs[0].rotor_thrusts.shape[1] == scenario.race.vehicle.rotor_count
    assert_same(flown, home, SAME)


@pytest.mark.parametrize(
    ("race", "delay"),
    [
        ("circle-34", 0.045),
        pytest.param("airsim-circle-34", 0.0125, marks=pytest.mark.check),
        pytest.param("real-circle", 0.045, marks=pytest.mark.check),
        pytest.param("lsy-level0", 0.0, marks=pytest.mark.check),
    ],
)
def test_a_real_race_is_flown_as_in_the_built_in_world(race, delay):
    """With dead time of whole periods and parts of them, openings, frames, and a start on the ground."""
    scenario = prepare(race)
    assert scenario.race.vehicle.delay == delay
    asked = np.tile(TUNED, (8, len(scenario.segments), 1))
    flown = Stepped("plant", plant).fly(scenario, asked, SEEDS, log=[0])
    assert_same(flown, BuiltIn("float64").fly(scenario, asked, SEEDS, log=[0]), SAME)


@pytest.mark.parametrize(
    ("delay", "noise"),
    [(0.0275, NOISE), (0.0025, {"measured_position": 0.02, "measured_velocity": 0.02, "measured_attitude": 0.01})],
)
def test_noise_and_dead_time_are_those_of_the_built_in_world(delay, noise):
    scenario, asked, seeds = make_scenario({"delay": delay}, noise=noise), parameters(4), SEEDS[:4]
    flown = Stepped("plant", plant).fly(scenario, asked, seeds, log=[1])
    assert_same(flown, BuiltIn("float64").fly(scenario, asked, seeds, log=[1]), SAME)


@pytest.mark.parametrize(("lanes", "instances"), [(3, 1), (1, 2), (2, 3), (20, 2)])
def test_a_flight_is_the_same_in_any_lane_and_instance(lanes, instances):
    scattered = parameters(8) * np.exp(0.9 * np.random.default_rng(0).standard_normal((8, 2, 5)))
    alone = Stepped("plant", plant).fly(NOISY, scattered, SEEDS, log=[2])
    assert len(set(alone.end_time.tolist())) > 2
    world = Stepped("plant", lambda scenario, number: plant(scenario, number, lanes), instances)
    assert_same(world.fly(NOISY, scattered, SEEDS, log=[2]), alone)
    order = np.random.default_rng(1).permutation(8)
    again = world.fly(NOISY, scattered[order], SEEDS[order])
    np.testing.assert_array_equal(again.mean_error, alone.mean_error[order])


def test_a_simulator_that_cannot_scale_its_thrust_is_given_other_commands():
    """Where no rotor saturates, a factor of the command is a factor of the thrust, but for the lag of the motors."""
    scenario = make_scenario(noise={"thrust_bias": 0.1})
    flown, commanded = (Stepped("plant", partial(_scaling, scales=scales)).fly(scenario, parameters(8), SEEDS) for scales in (True, False))
    exact = Stepped("plant", plant).fly(make_scenario(), parameters(1), SEEDS[:1])
    assert np.corrcoef(flown.mean_error, commanded.mean_error)[0, 1] > 0.9
    assert np.ptp(commanded.mean_error) > 0.5 * np.ptp(flown.mean_error)
    assert exact.mean_error[0] < commanded.mean_error.max()


def _scaling(scenario: Scenario, _instance: int, *, scales: bool) -> PlantSimulator:
    """The plant, which heeds the thrust factor of a start or leaves it to the world."""
    simulator = plant(scenario, 0)
    simulator.scales_thrust = scales
    reset = simulator.reset
    simulator.reset = reset if scales else lambda lane, start: reset(lane, Start(start.state))
    return simulator


def test_a_battery_is_drawn_down_as_in_the_built_in_world():
    draining = make_scenario({"battery": Battery(sag=0.2)})
    low, full = (
        Stepped("plant", plant).fly(scenario, parameters(1), SEEDS[:1], log=[0]).logs[0] for scenario in (draining, make_scenario())
    )
    home = BuiltIn("float64").fly(draining, parameters(1), SEEDS[:1], log=[0]).logs[0]
    rows = slice(min(len(log.times) for log in (low, full, home)) // 2, min(len(log.times) for log in (low, full, home)))
    sunk, expected = (float((log.states[rows, 2] - full.states[rows, 2]).mean()) for log in (low, home))
    assert expected < -0.01
    assert sunk == pytest.approx(expected, rel=0.3)


def test_an_attitude_of_the_other_sign_is_the_same_attitude():
    class Flipped(PlantSimulator):
        def states(self):
            states = super().states()
            states[:, 3:7] *= -1
            return states

    simulator = Flipped(NOISY.race.vehicle, NOISY.race.control_model)
    assert_same(
        Stepped("", lambda *_: simulator).fly(NOISY, parameters(2), SEEDS[:2]), Stepped("", plant).fly(NOISY, parameters(2), SEEDS[:2])
    )


def test_steps_that_do_not_divide_the_period_keep_its_clock():
    """A step of 3 ms under a period of 10 ms: over one second the clocks are not apart, and the flight is nearly the same."""

    class Coarse(PlantSimulator):
        step, flown = 0.0075, 0.0

        def advance(self, commands, duration):
            self.flown += duration
            super().advance(commands, duration)

    simulator = Coarse(NOISY.race.vehicle, NOISY.race.control_model)
    scenario = make_scenario()
    coarse = Stepped("coarse", lambda *_: simulator).fly(scenario, parameters(1), SEEDS[:1])
    fine = Stepped("fine", plant).fly(scenario, parameters(1), SEEDS[:1])
    assert simulator.flown == pytest.approx(fine.end_time[0], abs=0.0175)
    np.testing.assert_allclose(coarse.closest_distance, fine.closest_distance, atol=0.05)


def test_steps_that_make_no_periods_are_refused():
    class Slow(PlantSimulator):
        step = 0.02

    class Odd(PlantSimulator):
        step = 0.003

    vehicle = NOISY.race.vehicle
    with pytest.raises(InputError, match=r"on: a step of slow, 20 ms, is longer than the control period of 10 ms"):
        Stepped("slow", lambda *_: Slow(vehicle)).fly(NOISY, parameters(1), SEEDS[:1])
    with pytest.raises(InputError, match="its lanes share one clock"):
        Stepped("odd", lambda *_: Odd(vehicle, lanes=2)).fly(NOISY, parameters(1), SEEDS[:1])


def test_other_vehicles_are_refused():
    rows = vehicle_parameters_of(NOISY.race.vehicle)[None]
    with pytest.raises(HotlapError, match="moon flies the vehicle that it has"):
        Stepped("moon", plant).fly(NOISY, parameters(1), SEEDS[:1], vehicle_parameters=rows)


def test_no_flights_open_no_simulator():
    def refuse(*_):
        raise AssertionError

    assert len(Stepped("none", refuse).fly(NOISY, parameters(0), SEEDS[:0])) == 0
