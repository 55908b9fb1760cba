"""Flightmare's quadrotor, through a module such as a user builds for it."""

from __future__ import annotations

import sys
from types import ModuleType

import numpy as np
import pytest

from flight.scenarios import make_scenario
from hotlap.files.descriptions import load_quadrotor
from hotlap.worlds.flightmare import open_simulator
from hotlap.worlds.simulator import Start
from worlds import flightlib

VEHICLE = load_quadrotor("flightmare")
# uzh-rpg/flightmare, flightlib at d4218ae with configs/quadrotor_env.yaml, Runge-Kutta steps of 2.5 ms in float32: the rates at these
# times [s] after 2 rad/s were asked for by this rate loop, and the states under the script below
TIMES = (0.0025, 0.01, 0.025, 0.05, 0.1)
ROLL = (0.083, 0.311899, 0.690965, 1.143214, 1.632959)
YAW = (0.024138, 0.095651, 0.233729, 0.442499, 0.788926)
SCRIPT = (
    (0.01108, -0.00512, 100.04078, 0.99166, 0.08083, 0.10019, 0.00558, 0.20561, -0.12025, 0.48177, 1.71576, 1.25121, 0.21366),
    (0.12409, -0.10169, 100.19671, 0.96508, 0.21123, 0.15127, 0.03337, 0.97811, -0.9637, 1.03395, 0.13514, -0.31836, 0.54712),
    (0.38804, -0.39187, 100.44149, 0.98925, 0.11346, 0.03249, 0.0863, 1.54953, -1.83383, 1.39423, -1.74629, -1.3844, 0.63988),
    (0.69626, -0.79018, 100.73158, 0.98757, 0.04646, -0.06984, 0.13295, 1.46164, -2.09647, 1.41875, 0.65943, -0.15297, 0.37783),
    (0.97461, -1.23916, 100.98173, 0.97022, 0.17894, 0.02092, 0.16188, 1.38679, -2.45625, 1.04739, 1.44675, 1.33204, -0.10122),
)
HIGH = 100.0  # m, where the script began


@pytest.fixture
def module(monkeypatch):
    """A module that may be changed."""
    copy = ModuleType("my_flightlib")
    copy.Quadrotor = type("Quadrotor", (flightlib.Quadrotor,), {})
    monkeypatch.setitem(sys.modules, "my_flightlib", copy)
    return copy


def opened(module, vehicle=VEHICLE):
    return open_simulator(make_scenario(vehicle.model_dump()), 0, module.__name__)


def at(height: float) -> Start:
    return Start(np.array([0.0, 0.0, height, 1.0, *(0.0,) * 9]))


@pytest.mark.parametrize(("axis", "expected"), [(0, ROLL), (2, YAW)])
def test_a_rate_step_is_that_of_flightlib(module, axis, expected):
    simulator = opened(module)
    simulator.reset(0, at(10.0))
    command, rates = np.array([[9.81, 0.0, 0.0, 0.0]]), []
    command[0, 1 + axis] = 2.0
    for duration in np.diff([0.0, *TIMES]):
        simulator.advance(command, duration)
        rates.append(simulator.states()[0, 10 + axis])
    np.testing.assert_allclose(rates, expected, atol=1e-3)


def test_a_second_of_changing_commands_is_flown_as_in_flightlib(module):
    simulator = opened(module)
    simulator.reset(0, at(10.0))
    states = []
    for k in range(100):
        t = 0.01 * k
        command = [11 + 3 * np.sin(5 * t), 2 * np.sin(9 * t), 1.5 * np.sin(7 * t + 1), 0.8 * np.sin(4 * t)]
        simulator.advance(np.array([command]), 0.01)
        if (k + 1) % 20 == 0:
            states.append(simulator.states()[0] + [0, 0, HIGH - 10, *(0,) * 10])
    np.testing.assert_allclose(states, SCRIPT, atol=1e-3)
