"""The plant flies open loop as other simulators do, by figures that were recorded in them; `simulators.json` says in which versions.

In single precision they were recorded to five digits. A tolerance above 1e-3 says what another integrator does. All of them began at a
height of 100 m, where AirLib's air is that of 222 m above the sea.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.files.descriptions import load_quadrotor
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.rate_loop import RateLoop

from .open_loop import REST, OpenLoop

FIGURES = json.loads(Path(__file__).with_name("simulators.json").read_text(encoding="utf-8"))
AIRLIB, FLIGHTLIB, ROTORPY = FIGURES["airlib"], FIGURES["flightlib"], FIGURES["rotorpy"]
STEP, HELD = 0.003, 2  # AirLib's step [s]; steps from a signal to its rotor
HEIGHT = 122 + 100  # m
FULL = 4 * 4.1794  # N, all rotors at the signal 1 at sea level
HOVER = AIRLIB["hover"][0]
AIRSIM = load_quadrotor("airsim-122m")
TOLERANCE = 1e-3


def density(height: float) -> float:
    """Of the air over that at sea level, by the standard atmosphere."""
    return (1 - 0.0065 * height / 288.15) ** 4.25588


def in_air_of(height: float, **changes: Any) -> Quadrotor:
    """AirSim's drone at a height [m]: its thrust and drag are proportional to the density."""
    thinner = density(height) / density(122)
    least, largest = AIRSIM.rotor_thrust
    air = {"rotor_thrust": (least, largest * thinner), "body_drag": tuple(thinner * np.array(AIRSIM.body_drag))}
    return AIRSIM.model_copy(update={**air, **changes})


def fly_in_airlib(commands: Any, state: Any = REST, throttle: float = HOVER) -> np.ndarray:
    """States in AirLib's steps, shape (steps + 1, 13).

    Its velocities take the mean of the accelerations of two steps, and its rate loop sees them: the mean of our states of two steps, and
    half a step more of dead time within the loop.

    Args:
        commands: shape (steps, 4), throttle and body rates.
        state: shape (13,), where it begins.
        throttle: what the rotors do until the first command gets to them.
    """
    drone = in_air_of(HEIGHT, rate_delay=(HELD + 0.5) * STEP)
    full = FULL * density(HEIGHT)
    vehicle = OpenLoop(drone, state, throttle * full / 4, STEP)
    scale = np.array([full, 1.0, 1.0, 1.0])
    arriving = [np.array([throttle, 0.0, 0.0, 0.0])] * HELD + list(np.asarray(commands, dtype=float))
    states = np.vstack([vehicle.state, *(vehicle.fly(command * scale) for command in arriving[: len(commands)])])
    return np.vstack([states[:1], (states[1:] + states[:-1]) / 2])


def moving(velocity: tuple[float, ...] = (0, 0, 0), rates: tuple[float, ...] = (0, 0, 0)) -> np.ndarray:
    return np.array([*REST[:7], *velocity, *rates], dtype=float)


def held(steps: int, *command: float) -> np.ndarray:
    return np.tile(command, (steps, 1))


def scripted(time: Any) -> np.ndarray:
    """The commands that were recorded, thrust per mass and body rates, at times [s]."""
    return np.array([11 + 3 * np.sin(5 * time), 2 * np.sin(9 * time), 1.5 * np.sin(7 * time + 1), 0.8 * np.sin(4 * time)])


@pytest.mark.parametrize(("axis", "name"), [(0, "roll"), (1, "pitch")])
def test_a_rate_step_of_simpleflight_is_airlibs(axis, name):
    command = [HOVER, 0.0, 0.0, 0.0]
    command[1 + axis] = 2.0
    assert_allclose(fly_in_airlib(held(19, *command))[:, 10 + axis], AIRLIB[name], atol=TOLERANCE)


def test_a_yaw_step_of_simpleflight_is_airlibs():
    assert_allclose(fly_in_airlib(held(400, HOVER, 0, 0, 1))[99:400:100, 12], AIRLIB["yaw"], atol=TOLERANCE)


@pytest.mark.parametrize(("axis", "name"), [(0, "roll"), (1, "pitch")])
def test_a_rate_step_in_steps_of_the_built_in_world_keeps_within_two_percent_of_it(axis, name):
    drone, hover = in_air_of(HEIGHT), HOVER * FULL * density(HEIGHT)
    vehicle = OpenLoop(drone, thrust=hover / 4)
    command = np.array([hover, 0.0, 0.0, 0.0])
    states = [moving(), *vehicle.fly(command, 3)]  # the dead time outside of the loop
    command[1 + axis] = 2.0
    rates = np.vstack([*states, vehicle.fly(command, 25)])[:, 10 + axis]
    assert_allclose(np.interp(np.arange(20) * STEP, np.arange(len(rates)) * 0.0025, rates), AIRLIB[name], atol=0.04)


def test_thrust_follows_a_step_of_the_throttle_as_airlibs():
    full = FULL * density(HEIGHT)
    vehicle = OpenLoop(in_air_of(HEIGHT), thrust=0.3 * full / 4, step=STEP)
    vehicle.fly([0.3 * full, 0, 0, 0])
    velocity = [vehicle.state[9], *vehicle.fly([0.8 * full, 0, 0, 0], 9)[:, 9]]
    assert_allclose(np.diff(velocity) / STEP, AIRLIB["lift"][3:], atol=TOLERANCE)


def test_drag_is_airlibs():
    last = fly_in_airlib(held(100, HOVER, 0, 0, 0), moving((20, 0, 0)))[-1]
    assert_allclose(last[[7, 9]], AIRLIB["level"], atol=TOLERANCE)


def test_the_speed_of_falling_flat_is_that_of_airlibs_air():
    """AirLib's air grows denser on the way down; the recorded speed is the largest, 60 to 70 m above the start of a flight."""
    speeds = [OpenLoop(in_air_of(122 + above), thrust=0.0).fly([0, 0, 0, 0], 2500)[-1, 9] for above in (70, 60)]
    assert -speeds[0] > AIRLIB["falling"][0] > -speeds[1]


def test_below_a_throttle_of_a_twentieth_it_tumbles_freely():
    """To 0.03 rad/s: AirLib integrates the rates to first order."""
    last = fly_in_airlib(held(100, 0.03, 0, 0, 0), moving(rates=(6, 4, 3)), throttle=0.03)[-1]
    assert_allclose(last[10:], AIRLIB["tumbling"], atol=0.03)


@pytest.mark.parametrize("case", AIRLIB["mixer"])
def test_the_mixer_is_simpleflights(case):
    throttle, error, front_right, rear_left, front_left, rear_right = case
    drone = AIRSIM.model_copy(update={"motor_time": (0.0, 0.0), "rate_delay": 0.0})
    vehicle, largest = OpenLoop(drone), drone.rotor_thrust[1]
    vehicle.fly([throttle * 4 * largest, error, 0, 0])
    assert_allclose(vehicle.thrusts / largest, [front_left, front_right, rear_right, rear_left], atol=6e-6)


def test_scripted_commands_are_flown_as_in_airlib():
    """AirLib turns the thrust with the attitude of a step before: to 1 cm and 2 cm/s."""
    ends = np.floor(np.arange(1, 120) * 0.01 / STEP + 1e-9)  # of the control periods, in steps
    commands = np.array([scripted(0.01 * np.searchsorted(ends, k, side="right")) for k in range(333)]) / [4 * 4.179445, 1, 1, 1]
    states = fly_in_airlib(commands)
    for row, recorded in zip(states[[65, 132, 199, 265, 332]], np.array(AIRLIB["script"]), strict=True):
        assert_allclose(row[3:7], recorded[3:7], atol=TOLERANCE)
        assert_allclose(row[10:], recorded[10:], atol=TOLERANCE)
        assert_allclose(row[:3], recorded[:3] - [0, 0, 100], atol=0.01)
        assert_allclose(row[7:10], recorded[7:10], atol=0.02)


def fly_script(quadrotor: Quadrotor) -> np.ndarray:
    """States every 0.2 s under the scripted commands, shape (5, 13)."""
    vehicle = OpenLoop(quadrotor)
    return np.array([vehicle.fly(scripted(0.01 * k), 4)[-1] for k in range(100)])[19::20]


MARKS = [0, 3, 9, 19, 39]  # steps of 2.5 ms, of the recorded rate steps


@pytest.fixture
def flightmare() -> Quadrotor:
    return load_quadrotor("flightmare").model_copy(update={"inertia": tuple(FLIGHTLIB["inertia"])})


@pytest.mark.parametrize(("axis", "name"), [(0, "roll"), (2, "yaw")])
def test_a_rate_step_is_flightlibs(flightmare, axis, name):
    command = np.array([flightmare.gravity, 0.0, 0.0, 0.0])
    command[1 + axis] = 2.0
    assert_allclose(OpenLoop(flightmare).fly(command, 40)[MARKS, 10 + axis], FLIGHTLIB[name], atol=1e-5)


def test_scripted_commands_are_flown_as_in_flightlib(flightmare):
    """Flightlib turns the thrust half a step later: to 1 cm and 1 cm/s."""
    states, recorded = fly_script(flightmare), np.array(FLIGHTLIB["script"])
    assert_allclose(states[:, 3:7], recorded[:, 3:7], atol=1e-5)
    assert_allclose(states[:, 10:], recorded[:, 10:], atol=1e-5)
    assert_allclose(states[:, :3], recorded[:, :3] - [0, 0, 100], atol=0.01)
    assert_allclose(states[:, 7:10], recorded[:, 7:10], atol=0.01)


@pytest.fixture
def rotorpys() -> Quadrotor:
    """The hummingbird with RotorPy's rate loop: 20 1/s on every axis, without the torque that a turning body needs to keep its axis."""
    drone = load_quadrotor("hummingbird").model_copy(update={"motor_time": (0.0125, 0.0125)})
    of_one = drone.model_copy(update={"rate_loop": RateLoop(p=(1, 1, 1))}).hover_rate_gain
    return drone.model_copy(update={"rate_loop": RateLoop(p=tuple(20 / of_one))})


def test_scripted_commands_are_flown_as_in_rotorpy(rotorpys):
    """RotorPy's motors move within a step, ours before it: to 0.02 rad/s and as much of a radian, in the end 3 mm."""
    states, recorded = fly_script(rotorpys), np.array(ROTORPY["script"])
    assert_allclose(states[:, :3], recorded[:, :3] - [0, 0, 100], atol=0.005)
    assert_allclose(states[:, 3:7], recorded[:, 3:7], atol=0.005)
    assert_allclose(states[:, 7:10], recorded[:, 7:10], atol=0.01)
    assert_allclose(states[:, 10:], recorded[:, 10:], atol=0.02)


def test_a_rate_step_is_rotorpys_but_for_half_a_step_of_its_motors(rotorpys):
    after = OpenLoop(rotorpys).fly([rotorpys.gravity, 2, 0, 0], 40)[:, 10]
    assert_allclose((after[MARKS] + np.array([0, *after])[MARKS]) / 2, ROTORPY["roll"], atol=0.02)


def test_rotor_drag_is_rotorpys(rotorpys):
    last = OpenLoop(rotorpys, moving((9, 9, 9))).fly([rotorpys.gravity, 0, 0, 0], 40)[-1]
    assert_allclose(last[7:10], ROTORPY["slowed"], atol=1e-5)


def test_a_loop_without_gyroscopic_torque_misses_what_rotorpys_misses(rotorpys):
    """Roll and pitch to 0.03 rad/s; of yaw RotorPy reaches 2 % less."""
    last = OpenLoop(rotorpys).fly([rotorpys.gravity, 8, 8, 3], 200)[-1, 10:]
    assert_allclose(last[:2], ROTORPY["spun"][:2], atol=0.03)
    assert_allclose(last[2], ROTORPY["spun"][2], atol=0.07)
