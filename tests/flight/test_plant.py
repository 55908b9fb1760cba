"""The plant is a rigid body with thrust, lag, limits and drag, as the quadrotor's file says."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from hotlap.core.errors import HotlapError
from hotlap.dynamics import models
from hotlap.flight.plant import allocate_vehicle_state, autopilot_numbers, fly_period, vehicle_numbers
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import PLANT_STEP
from hotlap.race.rotors import RotorLayout
from hotlap.race.vehicle_parameters import VEHICLE_PARAMETERS, vehicle_parameters_of

STEP = models.plant_step()
DRAGLESS: dict[str, Any] = {"name": "box", "mass": 0.9, "inertia": (0.004, 0.006, 0.009), "arm": 0.2, "torque_ratio": 0.02}
RACER = Quadrotor(**DRAGLESS, rotor_thrust=(0.1, 6.0), motor_time=(0.02, 0.05))
DRAGGED = RACER.model_copy(update={"drag": (0.3, 0.2, 0.1), "rotor_drag": 0.02, "body_drag": (0.01, 0.02, 0.05)})
HOVER = np.array([RACER.gravity, 0.0, 0.0, 0.0])
SHARES = slice(18, 20)  # of the motors, in the vehicle's numbers


def rest(quadrotor: Quadrotor = RACER, thrusts: Any = None) -> np.ndarray:
    """Hovering, or with other rotor thrusts."""
    thrusts = np.full(4, quadrotor.mass * quadrotor.gravity / 4) if thrusts is None else np.asarray(thrusts)
    return np.concatenate([np.zeros(3), [1.0, 0, 0, 0], np.zeros(6), np.sqrt(thrusts)])


def simulate(
    state: np.ndarray,
    command: np.ndarray,
    seconds: float,
    quadrotor: Quadrotor = RACER,
    *,
    step: float = PLANT_STEP,
    frozen: bool = False,
    disturbance: Any = (1.0, 0.0, 0.0, 0.0),
    control_model: Quadrotor | None = None,
) -> np.ndarray:
    """States every step, shape (steps + 1, 17); frozen rotors keep their speed whatever they are asked for."""
    vehicle, autopilot = (
        vehicle_numbers(vehicle_parameters_of(quadrotor)[None], quadrotor.layout)[0],
        autopilot_numbers(control_model or quadrotor),
    )
    if frozen:
        vehicle[SHARES] = 0.0
    states = [state]
    for _ in range(round(seconds / step)):
        states.append(np.array(STEP(states[-1], command, vehicle, autopilot, np.array(disturbance), step)).ravel())
    return np.array(states)


def test_hover_stays():
    assert_allclose(simulate(rest(), HOVER, 0.5)[-1], rest(), atol=1e-12)


def test_attitudes_stay_unit_quaternions():
    states = simulate(rest(thrusts=[1, 3, 2, 4]), HOVER, 0.5, DRAGGED, frozen=True)
    assert_allclose(np.linalg.norm(states[:, 3:7], axis=1), 1.0, rtol=1e-14)


def test_without_thrust_it_falls_and_keeps_its_angular_momentum():
    state = rest(thrusts=np.zeros(4))
    state[10:13] = (4.0, -3.0, 2.0)
    states = simulate(state, HOVER, 0.5, step=5e-4, frozen=True)
    assert_allclose(states[-1, 7:10], [0, 0, -RACER.gravity * 0.5], atol=1e-12)
    inertia = np.array(RACER.inertia)
    momenta = [Rotation.from_quat(np.roll(row[3:7], -1)).apply(inertia * row[10:13]) for row in states]
    assert_allclose(momenta[-1], momenta[0], rtol=1e-4)


def derivative(quadrotor: Quadrotor, thrusts: np.ndarray, wind: np.ndarray) -> Any:
    """Newton and Euler, written with scipy's rotations: a body with constant rotor thrusts."""
    inertia, torque = np.array(quadrotor.inertia), quadrotor.torque_matrix @ thrusts
    drag, box = np.array(quadrotor.drag), np.array(quadrotor.body_drag)

    def rate(_: float, x: np.ndarray) -> np.ndarray:
        q, w = x[3:7], x[10:13]
        turn = Rotation.from_quat(np.roll(q, -1))
        air = turn.inv().apply(x[7:10])
        plane = quadrotor.rotor_drag * np.sqrt(thrusts).sum() * air * [1, 1, 0]
        force = [0, 0, thrusts.sum()] - plane - box * air * np.abs(air) - quadrotor.mass * drag * air
        acceleration = turn.apply(force) / quadrotor.mass - [0, 0, quadrotor.gravity] + wind
        spin = 0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)])
        return np.concatenate([x[7:10], spin, acceleration, (torque - np.cross(w, inertia * w)) / inertia])

    return rate


def test_the_body_is_integrated_to_second_order():
    """Halving the step divides the error by four; with every kind of drag, and wind."""
    thrusts, wind = np.array([2.0, 2.3, 2.2, 2.4]), np.array([0.5, -1.0, 0.2])
    state = rest(thrusts=thrusts)
    state[7:13] = (9.0, -4.0, 2.0, 1.0, 2.0, -1.0)
    exact = solve_ivp(derivative(DRAGGED, thrusts, wind), (0, 0.4), state[:13], rtol=1e-11, atol=1e-11).y[:, -1]
    errors = []
    for step in (0.005, 0.0025, 0.00125):
        last = simulate(state, HOVER, 0.4, DRAGGED, step=step, frozen=True, disturbance=(1.0, *wind))[-1]
        errors.append(np.abs(last[:13] - exact).max())
    assert errors[1] < 1e-3
    assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2.0, atol=0.2)


def test_the_rigid_body_is_that_of_mujoco():
    lever = RACER.arm / np.sqrt(2)
    places, spins = [(lever, lever), (lever, -lever), (-lever, -lever), (-lever, lever)], (1, -1, 1, -1)
    ratio, inertia = RACER.torque_ratio, " ".join(map(str, RACER.inertia))
    sites = "".join(f'<site name="r{k}" pos="{x} {y} 0"/>' for k, (x, y) in enumerate(places))
    motors = "".join(f'<general site="r{k}" gear="0 0 1 0 0 {spin * ratio}"/>' for k, spin in enumerate(spins))
    model = mujoco.MjModel.from_xml_string(f"""<mujoco>
      <option timestep="0.001" integrator="RK4" gravity="0 0 -{RACER.gravity}"><flag contact="disable"/></option>
      <worldbody><body><freejoint/><inertial pos="0 0 0" mass="{RACER.mass}" diaginertia="{inertia}"/>{sites}</body></worldbody>
      <actuator>{motors}</actuator></mujoco>""")
    data, thrusts = mujoco.MjData(model), np.array([2.5, 2.8, 2.3, 2.6])
    data.qvel[:] = (1.0, 2.0, 3.0, 1.0, -2.0, 0.5)
    data.ctrl[:] = thrusts
    state = rest(thrusts=thrusts)
    state[7:13] = data.qvel
    for _ in range(400):
        mujoco.mj_step(model, data)
    last = simulate(state, HOVER, 0.4, step=0.0005, frozen=True)[-1]
    assert np.abs(data.qvel[3:]).max() > 4.0  # it tumbles
    assert_allclose(last[:7], data.qpos, atol=1e-5)
    assert_allclose(last[7:13], data.qvel, atol=1e-4)


@pytest.mark.parametrize(("command", "time", "speed"), [(14.0, 0.02, "up"), (6.0, 0.05, "down")])
def test_rotor_speeds_follow_their_command_with_the_lag_of_their_direction(command, time, speed):
    states = simulate(rest(), np.array([command, 0, 0, 0]), 0.1)
    first, last = rest()[13], np.sqrt(RACER.mass * command / 4)
    elapsed = PLANT_STEP * np.arange(len(states))
    expected = last + (first - last) * np.exp(-elapsed / time)
    assert_allclose(states[:, 13:], np.tile(expected[:, None], 4), rtol=1e-9, err_msg=speed)


def test_without_lag_rotors_follow_at_once():
    quick = RACER.model_copy(update={"motor_time": (0.0, 0.0)})
    assert_allclose(simulate(rest(), np.array([14.0, 0, 0, 0]), PLANT_STEP, quick)[-1, 13:] ** 2, 14.0 * RACER.mass / 4)


@pytest.mark.parametrize("layout", RotorLayout)
@pytest.mark.parametrize("axis", range(3))
def test_a_commanded_rate_is_reached_on_its_own_axis(layout, axis):
    quadrotor = RACER.model_copy(update={"layout": layout, "rotor_thrust": (0.0, 20.0), "motor_time": (0.0, 0.0)})
    command = HOVER.copy()
    command[1 + axis] = 0.3
    states = simulate(rest(), command, 0.6, quadrotor)
    others = [k for k in range(3) if k != axis]
    assert_allclose(states[:, 10 + np.array(others)], 0.0, atol=1e-6)
    gain = quadrotor.rate_gain[axis]
    assert_allclose(states[-1, 10 + axis], 0.3 * (1 - np.exp(-gain * 0.6)), rtol=0.01)
    assert_allclose(np.sum(states[-1, 13:] ** 2), quadrotor.mass * quadrotor.gravity, rtol=1e-6)


@pytest.mark.parametrize(("axis", "direction"), [(0, [0, -1, 0]), (1, [1, 0, 0])])
def test_roll_goes_right_and_pitch_goes_forward(axis, direction):
    """x forward, y left, z up: a positive roll tilts the thrust to the right, a positive pitch forward."""
    command = HOVER.copy()
    command[1 + axis] = 0.5
    velocity = simulate(rest(), command, 0.5)[-1, 7:9]
    assert velocity @ direction[:2] > 0.2
    assert abs(velocity @ direction[1::-1]) < 1e-6


def test_a_rate_that_is_wanted_is_kept():
    """The rate loop makes the torque that a spinning body needs to go on about the same axis, w x J w."""
    quick = RACER.model_copy(update={"motor_time": (0.0, 0.0)})
    state = rest()
    state[10:13] = (3.0, -2.0, 1.5)
    states = simulate(state, np.array([15.0, 3.0, -2.0, 1.5]), 0.2, quick)
    assert_allclose(states[:, 10:13], np.tile(state[10:13], (len(states), 1)), atol=1e-9)


def test_rotor_thrusts_keep_their_limits():
    wild = np.array([60.0, 30.0, -30.0, 10.0])
    for command in (wild, -wild):
        thrusts = simulate(rest(), command, 0.3)[:, 13:] ** 2
        assert thrusts.min() >= RACER.rotor_thrust[0] * (1 - 1e-12)
        assert thrusts.max() <= RACER.rotor_thrust[1] * (1 + 1e-12)
    assert thrusts.min() < 0.11
    assert thrusts.max() > 1.0


def test_drag_ends_in_the_terminal_speed():
    """m g = k v^2 along the body's axis, falling flat; the same with linear drag, g = d v."""
    square = RACER.model_copy(update={"body_drag": (0.0, 0.0, 0.4)})
    linear = RACER.model_copy(update={"drag": (0.0, 0.0, 2.0)})
    weight, empty = RACER.mass * RACER.gravity, rest(thrusts=np.zeros(4))
    assert simulate(empty, HOVER, 5.0, square, step=0.01, frozen=True)[-1, 9] == pytest.approx(-np.sqrt(weight / 0.4), rel=1e-6)
    assert simulate(empty, HOVER, 8.0, linear, step=0.01, frozen=True)[-1, 9] == pytest.approx(-RACER.gravity / 2.0, rel=1e-6)


def test_thrust_errors_wind_and_a_wrong_mass_act():
    lift = simulate(rest(), HOVER, 0.1, disturbance=(1.1, 0, 0, 0))[-1]
    assert lift[9] == pytest.approx(0.1 * RACER.gravity * 0.1, rel=1e-6)
    blown = simulate(rest(), HOVER, 0.1, disturbance=(1.0, 2.0, -1.0, 0.5))[-1]
    assert_allclose(blown[7:10], [0.2, -0.1, 0.05], rtol=1e-9)
    heavy = simulate(rest(), HOVER, 1.0, RACER.model_copy(update={"mass": 1.0}), control_model=RACER)[-1]
    assert heavy[9] < -0.5


def test_damping_weakens_the_torque_that_is_asked_for():
    command = HOVER + [0, 0.5, 0, 0]
    damped = RACER.model_copy(update={"torque_damping": 0.5})
    assert simulate(rest(), command, 0.1, damped)[-1, 10] < 0.95 * simulate(rest(), command, 0.1)[-1, 10]


def test_vehicle_parameters_are_the_quadrotors_numbers_in_the_stated_columns():
    values = dict(zip(VEHICLE_PARAMETERS, vehicle_parameters_of(DRAGGED), strict=True))
    assert values["mass"] == DRAGGED.mass
    assert (values["motor_time_up"], values["motor_time_down"]) == DRAGGED.motor_time
    assert [values[f"body_drag_{axis}"] for axis in "xyz"] == list(DRAGGED.body_drag)
    assert [values[f"rate_gain_{axis}"] for axis in "xyz"] == list(DRAGGED.rate_gain)
    assert (values["delay"], values["gravity"]) == (DRAGGED.delay, DRAGGED.gravity)
    assert_allclose(vehicle_numbers(vehicle_parameters_of(DRAGGED)[None], RotorLayout.X)[0, 4:16], DRAGGED.torque_matrix.ravel())


@pytest.mark.parametrize(("column", "value"), [("mass", 0.0), ("inertia_y", -1.0), ("drag_x", np.nan), ("motor_time_up", np.inf)])
def test_impossible_vehicle_parameters_are_named(column, value):
    vehicles = np.tile(vehicle_parameters_of(RACER), (3, 1))
    vehicles[1, VEHICLE_PARAMETERS.index(column)] = value
    with pytest.raises(HotlapError, match=rf"vehicle_parameters\[1\]: {column}"):
        vehicle_numbers(vehicles, RotorLayout.X)


def test_the_mixer_makes_what_the_rate_loop_asks_for():
    mixer = autopilot_numbers(RACER)[4:].reshape(4, 4)
    wanted = np.array([9.0, 0.1, -0.2, 0.03])
    thrusts = mixer @ wanted
    assert_allclose([thrusts.sum(), *(RACER.torque_matrix @ thrusts)], wanted, rtol=1e-12)


def test_in_a_period_the_older_command_acts_first():
    vehicle_state = allocate_vehicle_state(1, np.float64)
    vehicle_state.state[:, 0], vehicle_state.step[0], vehicle_state.older_steps[0] = rest(), PLANT_STEP, 3
    vehicle_state.vehicle[:, 0], vehicle_state.autopilot[:, 0] = (
        vehicle_numbers(vehicle_parameters_of(RACER)[None], RACER.layout)[0],
        autopilot_numbers(RACER),
    )
    vehicle_state.disturbance[0] = 1.0
    vehicle_state.older[:, 0], vehicle_state.acting[:, 0] = (14.0, 0, 0, 0), (6.0, 0, 0, 0)
    place_before = vehicle_state.state[:3, 0].copy()
    fly_period.py_func(type(vehicle_state)(*(array[..., 0] for array in vehicle_state)), 4)
    halfway = simulate(rest(), np.array([14.0, 0, 0, 0]), 3 * PLANT_STEP)[-1]
    assert_allclose(vehicle_state.state[:, 0], simulate(halfway, np.array([6.0, 0, 0, 0]), PLANT_STEP)[-1], rtol=1e-12)
    assert_allclose(vehicle_state.before[:, 0], place_before)
