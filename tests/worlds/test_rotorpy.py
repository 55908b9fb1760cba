"""RotorPy flies our vehicles as recorded of RotorPy 3.0.0 itself, with its own integrator."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from flight.scenarios import TUNED, make_scenario, parameters
from hotlap.core.records import End
from hotlap.files.descriptions import load_quadrotor
from hotlap.planning.preparation import prepare
from hotlap.race.quadrotor import Quadrotor
from hotlap.worlds import rotorpy
from hotlap.worlds.separate import Separate
from hotlap.worlds.simulator import SimulatorError, Start
from hotlap.worlds.stepped import Stepped
from worlds.contract import SimulatorContract

needed = pytest.mark.skipif(not rotorpy.installed(), reason="rotorpy is not installed")
HUMMINGBIRD = load_quadrotor("hummingbird")
HIGH = np.array([0.0, 0, 100, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0])
HOVER = (9.81, 0.0, 0.0, 0.0)

# Multirotor "cmd_ctbr" of rotorpy 3.0.0, the hummingbird with k_w 20 and tau_m 0.0125, steps of 2.5 ms, RK45
RECORDED = HUMMINGBIRD.model_copy(update={"rate_gain": (20.0, 20.0, 20.0), "motor_time": (0.0125, 0.0125)})
ROLL_STEP = {1: 0.009616, 4: 0.125916, 10: 0.538827, 20: 1.210013, 40: 1.83833}  # rad/s after so many steps, 2 rad/s asked
SCRIPT = [  # state at 0.2, 0.4 .. 1 s under `script`
    (0.01117, -0.00496, 100.03477, 0.99057, 0.08452, 0.10678, 0.01472, 0.21361, -0.12058, 0.43385, 1.83721, 1.3284, 0.4317),
    (0.13008, -0.10355, 100.17801, 0.96067, 0.22044, 0.15587, 0.06496, 1.03059, -0.98193, 0.95963, 0.03819, -0.39497, 0.76337),
    (0.40429, -0.39591, 100.41085, 0.9849, 0.11674, 0.01772, 0.12657, 1.57315, -1.82876, 1.35956, -1.83314, -1.49366, 0.6337),
    (0.70377, -0.78936, 100.69775, 0.98185, 0.05772, -0.08797, 0.1578, 1.3508, -2.05874, 1.4139, 0.81828, -0.08252, 0.11943),
    (0.9518, -1.23099, 100.94773, 0.96586, 0.20366, 0.01916, 0.15898, 1.20945, -2.42503, 1.04671, 1.5181, 1.39842, -0.47412),
]
SAME = 1e-4


def script(time: float) -> tuple[float, ...]:
    """Thrust and rates that turn hard about all axes."""
    return 11 + 3 * np.sin(5 * time), 2 * np.sin(9 * time), 1.5 * np.sin(7 * time + 1), 0.8 * np.sin(4 * time)


def flown(vehicle: Quadrotor, state: np.ndarray = HIGH, thrust_factor: float = 1.0) -> rotorpy.RotorPy:
    simulator = rotorpy.RotorPy(vehicle)
    simulator.reset(0, Start(state, thrust_factor))
    return simulator


def advance(simulator: rotorpy.RotorPy, command: tuple[float, ...], duration: float) -> np.ndarray:
    simulator.advance(np.array([command]), duration)
    return simulator.states()[0]


def moving(*velocity: float) -> np.ndarray:
    state = HIGH.copy()
    state[7:10] = velocity
    return state


@needed
class TestRotorPy(SimulatorContract):
    def make(self, quadrotor):
        return rotorpy.RotorPy(quadrotor)


@needed
@pytest.mark.check
class TestRotorPyElsewhere(SimulatorContract):
    def make(self, quadrotor):
        return Separate(rotorpy.RotorPy, quadrotor)

    def lose(self, simulator):
        simulator._process.kill()


@needed
def test_a_step_of_roll_rate_is_as_recorded():
    simulator = flown(RECORDED)
    rates = {k: advance(simulator, (9.81, 2.0, 0.0, 0.0), rotorpy.STEP)[10] for k in range(1, 41)}
    assert {k: rates[k] for k in ROLL_STEP} == pytest.approx(ROLL_STEP, abs=SAME)


@needed
def test_hard_turns_are_as_recorded():
    simulator = flown(RECORDED)
    states = [advance(simulator, script(0.01 * k), 0.01) for k in range(100)]
    np.testing.assert_allclose(states[19::20], SCRIPT, rtol=0, atol=SAME)


@needed
def test_the_rotors_drag_is_as_recorded():
    state = advance(flown(RECORDED, moving(9, 9, 9)), HOVER, 0.1)
    np.testing.assert_allclose(state[7:10], [8.818096, 8.818096, 9.0], atol=SAME)


@needed
def test_its_rate_loop_does_not_feed_gyroscopic_torque_forward():
    state = advance(flown(RECORDED), (9.81, 8.0, 8.0, 3.0), 0.5)
    np.testing.assert_allclose(state[10:], [7.08257, 8.74381, 2.93639], atol=SAME)


@needed
@pytest.mark.parametrize("vehicle", ["airsim", "five-inch", "cf21b-500"])
def test_any_vehicle_hovers_where_it_is(vehicle):
    quadrotor = load_quadrotor(vehicle)
    simulator = flown(quadrotor)
    state = advance(simulator, (quadrotor.gravity, 0, 0, 0), 0.5)
    np.testing.assert_allclose(state, HIGH, atol=1e-6)
    np.testing.assert_allclose(simulator.rotor_thrusts(), quadrotor.mass * quadrotor.gravity / 4, rtol=1e-6)


@needed
def test_linear_drag_slows_as_it_should():
    vehicle = HUMMINGBIRD.model_copy(update={"rotor_drag": 0.0, "drag": (0.3, 0.5, 0.0)})
    state = advance(flown(vehicle, moving(8, 6, 0)), HOVER, 1.0)
    np.testing.assert_allclose(state[7:9], [8 * np.exp(-0.3), 6 * np.exp(-0.5)], rtol=1e-4)


@needed
def test_quadratic_drag_acts_along_each_axis_by_itself():
    vehicle = HUMMINGBIRD.model_copy(update={"rotor_drag": 0.0, "body_drag": (0.1, 0.2, 0.0)})
    state = advance(flown(vehicle, moving(3, -4, 0)), HOVER, rotorpy.STEP)
    np.testing.assert_allclose((state[7:9] - [3, -4]) / rotorpy.STEP, np.array([-0.1 * 9, 0.2 * 16]) / vehicle.mass, rtol=1e-2)


@needed
def test_rotors_take_longer_down_than_up():
    vehicle = HUMMINGBIRD.model_copy(update={"motor_time": (0.01, 0.04)})
    simulator, hover = flown(vehicle), vehicle.mass * vehicle.gravity / 4
    most = vehicle.rotor_thrust[1]
    advance(simulator, (60.0, 0, 0, 0), 0.01)
    expected = (np.sqrt(most) + (np.sqrt(hover) - np.sqrt(most)) * np.exp(-1)) ** 2
    np.testing.assert_allclose(simulator.rotor_thrusts()[0], expected, rtol=2e-3)
    simulator = flown(vehicle)
    advance(simulator, (0.0, 0, 0, 0), 0.04)
    np.testing.assert_allclose(simulator.rotor_thrusts()[0], hover * np.exp(-2), rtol=2e-3)


@needed
def test_thrust_that_is_off_lifts_that_much_more():
    state = advance(flown(HUMMINGBIRD, thrust_factor=1.1), HOVER, 0.1)
    assert state[9] == pytest.approx(0.1 * 9.81 * 0.1, rel=1e-4)


@needed
def test_the_rate_loop_takes_the_autopilots_mass_to_be_true():
    heavier = HUMMINGBIRD.model_copy(update={"mass": 1.1 * HUMMINGBIRD.mass})
    simulator = rotorpy.RotorPy(heavier, HUMMINGBIRD)
    simulator.reset(0, Start(HIGH))
    state = advance(simulator, HOVER, 0.5)
    assert state[9] == pytest.approx(-0.5 * 9.81 * (1 - 1 / 1.1), rel=0.1)


@needed
def test_a_race_flown_there_is_flown_as_in_the_built_in_world():
    scenario = make_scenario()
    flights = Stepped("rotorpy", rotorpy.open_simulator).fly(scenario, parameters(1), np.array([0]))
    assert flights.end[0] == End.FINISHED
    assert flights.mean_error[0] < 0.1


@needed
@pytest.mark.check
def test_a_real_race_is_finished_with_weights_of_the_built_in_world():
    scenario = prepare("circle-34")
    asked = np.tile(TUNED, (1, len(scenario.segments), 1))
    flights = Stepped("rotorpy", rotorpy.open_simulator).fly(scenario, asked, np.array([0]))
    assert flights.end[0] == End.FINISHED
    assert flights.mean_error[0] < 0.7


@needed
@pytest.mark.check
def test_instances_in_processes_of_their_own_fly_the_same_flights():
    scenario = make_scenario(noise={"position": 0.05})
    alone = Stepped("rotorpy", rotorpy.open_simulator).fly(scenario, parameters(3), np.arange(3))
    crew = Stepped("rotorpy", rotorpy.open_simulator, instances=2)
    together = crew.fly(scenario, parameters(3), np.arange(3))
    crew.close()
    np.testing.assert_array_equal(alone.clock_distance, together.clock_distance)


@needed
def test_an_argument_is_refused():
    with pytest.raises(SimulatorError, match="rotorpy takes no argument, not 'x'"):
        rotorpy.open_simulator(make_scenario(), 0, "x")


def test_without_the_package_it_says_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "rotorpy.vehicles.multirotor", None)
    monkeypatch.setitem(sys.modules, "rotorpy", None)
    with pytest.raises(SimulatorError, match=r"rotorpy is not installed: pip install 'hotlap\[rotorpy\]'"):
        rotorpy.RotorPy(HUMMINGBIRD)
