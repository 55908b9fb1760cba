"""Flightmare's quadrotor, through a module such as a user builds for it."""

from __future__ import annotations

import sys
from types import ModuleType

import numpy as np
import pytest

from flight.scenarios import make_scenario, parameters
from hotlap.core.errors import InputError
from hotlap.files.descriptions import load_quadrotor
from hotlap.worlds.built_in import BuiltIn
from hotlap.worlds.flightmare import CALLS, STEP, Flightmare, open_simulator
from hotlap.worlds.simulator import SimulatorError, Start
from hotlap.worlds.stepped import Stepped
from worlds import flightlib
from worlds.contract import SimulatorContract

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
    return open_simulator(make_scenario(vehicle.model_dump(), model=vehicle.model_dump()), 0, module.__name__)


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


def test_it_starts_where_it_is_placed_with_its_rotors_as_in_hover(module):
    start = np.array([1.0, 2.0, 3.0, 0.5, 0.5, 0.5, 0.5, 0.3, 0.2, 0.1, 0.3, 0.2, 0.1])
    simulator = opened(module)
    for _ in range(2):
        simulator.reset(0, Start(start))
        np.testing.assert_array_equal(simulator.states()[0], start)
        np.testing.assert_allclose(simulator.rotor_thrusts(), np.full((1, 4), 0.73 * 9.81 / 4), rtol=1e-6)
        simulator.advance(np.array([[20.0, 5.0, 5.0, 1.0]]), 0.5)


def test_the_rate_loop_runs_every_2_5_ms(module):
    simulator = opened(module)
    simulator.reset(0, at(10.0))
    simulator._drone.steps.clear()
    simulator.advance(np.array([[9.81, 0.0, 0.0, 0.0]]), 0.05)
    assert simulator._drone.steps == [STEP] * 20


def test_more_thrust_is_given_than_flightlibs_own_rate_mode_gives(module):
    """That one limits the thrust to 11.22 m/s^2 and rates to 6 rad/s."""
    simulator = opened(module)
    simulator.reset(0, at(10.0))
    simulator.advance(np.array([[40.0, 0.0, 9.0, 0.0]]), 0.3)
    assert simulator.rotor_thrusts().sum() == pytest.approx(40 * VEHICLE.mass, rel=0.01)
    assert simulator.states()[0, 11] == pytest.approx(9.0, abs=0.1)


def test_rotor_thrusts_are_those_asked_for_where_the_module_does_not_tell():
    class Silent:
        def __init__(self):
            self.drone = flightlib.Quadrotor()
            self.reset, self.set_state, self.step, self.state = (getattr(self.drone, name) for name in CALLS)

    simulator = Flightmare("silent", Silent(), VEHICLE)
    simulator.reset(0, at(10.0))
    np.testing.assert_allclose(simulator.rotor_thrusts(), np.full((1, 4), VEHICLE.mass * VEHICLE.gravity / 4))


def test_a_flight_beyond_the_box_is_refused(module):
    opened(module)
    module.BOX = 5.0
    with pytest.raises(
        InputError, match=r"^on: the flight goes \d+ m from the origin, and my_flightlib keeps drones within 5 m \(its BOX\)$"
    ):
        opened(module)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("", "needs the module that you have built for flightlib: flightmare:my_module"),
        ("no_such_module", "the module no_such_module cannot be loaded: ModuleNotFoundError"),
        ("json", "the module json has no Quadrotor"),
    ],
)
def test_a_module_that_is_none_is_named(name, message):
    with pytest.raises(InputError, match=f"^on: .*{message}"):
        open_simulator(make_scenario(), 0, name)


def test_what_a_module_lacks_is_named(module):
    module.Quadrotor = type("Quadrotor", (), {"reset": lambda self: None, "state": lambda self: [0] * 13})
    with pytest.raises(InputError, match=r"lacks Quadrotor\.set_state, Quadrotor\.step"):
        opened(module)


@pytest.mark.parametrize("told", [None, [0.0] * 12, "state", [float("nan")] * 13, [[1.0], [2.0, 3.0]]])
def test_a_state_that_is_none_loses_the_simulator(module, told):
    module.Quadrotor.state = lambda self: told
    with pytest.raises(SimulatorError, match=r"^my_flightlib: Quadrotor\.state\(\) must return 13 finite numbers, not"):
        opened(module).reset(0, at(10.0))


def test_what_goes_wrong_in_the_module_is_one_line(module):
    def step(*_):
        raise RuntimeError("integrator\nfailed")

    module.Quadrotor.step = step
    with pytest.raises(SimulatorError, match=r"^my_flightlib: Quadrotor\.step: RuntimeError: integrator\\nfailed$"):
        opened(module).reset(0, at(10.0))

    def make(_):
        raise OSError("no quadrotor_env.yaml")

    module.Quadrotor.__init__ = make
    with pytest.raises(SimulatorError, match=r"^my_flightlib: Quadrotor: OSError: no quadrotor_env\.yaml$"):
        opened(module)


def test_a_race_is_flown_as_in_the_built_in_world(module):
    scenario = make_scenario(VEHICLE.model_dump(), model=VEHICLE.model_dump(), noise={"position": 0.03, "thrust": 0.01, "rates": 0.02})
    asked, seeds = parameters(2), np.arange(2)
    home = BuiltIn("float64").fly(scenario, asked, seeds)
    away = Stepped("flightmare", lambda *_: open_simulator(scenario, 0, module.__name__)).fly(scenario, asked, seeds)
    np.testing.assert_array_equal(away.end, home.end)
    np.testing.assert_allclose(away.mean_error, home.mean_error, atol=5e-3)
    np.testing.assert_allclose(away.closest_distance, home.closest_distance, atol=0.02)


class TestContract(SimulatorContract):
    """Its rotors are spun up for half a second, and it flies the vehicle of flightlib alone."""

    quadrotor = VEHICLE
    scenario = make_scenario(VEHICLE.model_dump(), model=VEHICLE.model_dump(), noise={"thrust": 0.02, "rates": 0.1, "position": 0.05})

    def make(self, quadrotor):
        return Flightmare("flightlib", flightlib.Quadrotor(), quadrotor)
