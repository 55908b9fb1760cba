"""Vehicles for crazyflow: a quadrotor of ours as crazyflow describes one, and crazyflow's own under body rates. Loads JAX."""

# pyright: reportMissingImports=false, reportAttributeAccessIssue=false, reportArgumentType=false, reportOptionalMemberAccess=false

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, cast

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from crazyflow.control import Control
from crazyflow.control.mellinger import control_body_rate2force_torque, control_force_torque2rotor_vel
from crazyflow.control.transform import motor_force2rotor_vel
from crazyflow.drones import Drone
from crazyflow.sim import Dynamics, Sim
from crazyflow.sim.data import SimData
from crazyflow.sim.dynamics import first_principles_dynamics
from crazyflow.sim.functional import body_rate_control
from crazyflow.sim.integration import rk4
from crazyflow.sim.sim import increment_steps
from jax.scipy.spatial.transform import Rotation
from numpy.typing import NDArray

from hotlap.core.errors import UnknownNameError
from hotlap.race.quadrotor import Quadrotor
from hotlap.worlds.simulator import SimulatorError

Floats = NDArray[np.float64]

FASTEST = 20000.0  # revolutions a minute at full thrust, where a vehicle does not say it: any will do
LEAST_MOTOR_TIME = 2e-3  # s, so that its integrator is stable
PWM = 65535.0  # its full scale
NO_LIMIT = 1e9  # of its PWM
DEFAULT = "cf21B_500"
ROTOR_DRAG, BODY_DRAG = "hotlap_rotor_drag", "hotlap_body_drag"


def build(drone: str, lanes: int, step: float) -> Sim:
    """Crazyflow with a drone of its own in each of so many worlds, without a ground, under body rates.

    Its rate loop would also level the drone, as a Crazyflie's does that is given body rates: these terms are left out, as crazyflow says
    how to track body rates alone.

    Raises:
        UnknownNameError: it has no such drone.
    """
    known = [str(name) for name in Drone]
    if drone and drone not in known:
        raise UnknownNameError("drone of crazyflow", drone, known, key="on")
    frequency = round(1 / step)
    with _quiet():
        sim = Sim(
            n_worlds=lanes,
            drone=Drone(drone or DEFAULT),
            dynamics=Dynamics.first_principles,
            control=Control.body_rate,
            freq=frequency,
            body_rate_freq=frequency,
            force_torque_freq=frequency,
        )
    gains = sim.data.controls.body_rate.params
    _set_controllers(sim, gains | {"kR": jnp.zeros(3), "ki_m": jnp.zeros(3)}, sim.data.controls.force_torque.params)
    return sim


def become(sim: Sim, vehicle: Quadrotor, autopilot: Quadrotor) -> None:
    """Make crazyflow's drones a quadrotor of ours, whose rate loop takes another's mass, inertia and mixer to be true.

    Raises:
        SimulatorError: its rotors do not sit in a square.
    """
    fastest = FASTEST if vehicle.rotor_speed is None else vehicle.rotor_speed * 30 / np.pi
    curve = np.array([0.0, 0.0, vehicle.rotor_thrust[1] / fastest**2])
    up, down = (1 / max(time, LEAST_MOTOR_TIME) for time in vehicle.motor_time)
    inertia = np.diag(vehicle.inertia)
    params = sim.data.params.replace(
        mass=jnp.array([vehicle.mass]),
        L=jnp.array([_lever(vehicle)]),
        prop_inertia=jnp.array([vehicle.rotor_inertia]),
        gravity_vec=jnp.array([0.0, 0.0, -vehicle.gravity]),
        J=jnp.array(inertia),
        J_inv=jnp.array(np.linalg.inv(inertia)),
        rpm2thrust=jnp.array(curve[None]),
        rpm2torque=jnp.array(vehicle.torque_ratio * curve[None]),
        mixing_matrix=jnp.array(_mixing(vehicle)),
        drag_matrix=jnp.array(-vehicle.mass * np.diag(vehicle.drag)),
        rotor_dyn_coef=jnp.array([[up, 0.0, down, 0.0]]),
    )
    drags = {ROTOR_DRAG: jnp.array([vehicle.rotor_drag, vehicle.rotor_drag, vehicle.inflow]), BODY_DRAG: jnp.array(vehicle.body_drag)}
    sim.data = sim.data.replace(params=params, plugins=drags)
    _set_controllers(sim, *_controllers(vehicle, autopilot, curve))


@cache
def stepper(own: bool) -> Callable[[SimData, Floats, int], SimData]:
    """(crazyflow's data, body rates and thrust as it orders them, number of steps) -> its data after them.

    Compiled once for all vehicles of ours, and once for all of crazyflow's, whatever the number of steps.

    Args:
        own: whether the drone is one of crazyflow's.
    """
    stages = control_body_rate2force_torque, control_force_torque2rotor_vel, *(() if own else (_drag,)), _integrate, increment_steps

    def step(_: int, data: SimData) -> SimData:
        for stage in stages:
            data = stage(data)
        return data

    @jax.jit
    def advance(data: SimData, commands: Floats, steps: int) -> SimData:
        return jax.lax.fori_loop(0, steps, step, body_rate_control(data, commands))

    return advance


def rotor_speed(sim: Sim, thrust: float) -> float:
    """[1/min] at which a rotor gives a thrust [N]."""
    return float(motor_force2rotor_vel(np.array([thrust]), np.asarray(sim.data.params.rpm2thrust, dtype=np.float64))[0])


@jax.jit
def place(data: SimData, lane: int, state: jax.Array, rotor_speed: float) -> SimData:
    """Crazyflow's data with one drone placed, its rate loop new.

    Args:
        data: before.
        lane: of the drone.
        state: shape (13,), with the attitude (x, y, z, w).
        rotor_speed: [1/min] of all rotors.
    """
    s, rates = data.states, data.controls.body_rate
    states = s.replace(
        pos=s.pos.at[lane, 0].set(state[:3]),
        quat=s.quat.at[lane, 0].set(state[3:7]),
        vel=s.vel.at[lane, 0].set(state[7:10]),
        ang_vel=s.ang_vel.at[lane, 0].set(state[10:]),
        rotor_vel=s.rotor_vel.at[lane, 0].set(rotor_speed),
    )
    rates = rates.replace(
        cmd=rates.cmd.at[lane].set(0.0),
        prev_ang_vel=rates.prev_ang_vel.at[lane, 0].set(state[10:]),
        r_int_error=rates.r_int_error.at[lane].set(0.0),
    )
    return data.replace(states=states, controls=data.controls.replace(body_rate=rates))


@contextmanager
def _quiet() -> Iterator[None]:
    """Without MuJoCo's remark about the scene's prefix, which it would also write into a file here."""
    settings = cast("Any", mujoco).MjLogConfig  # its stubs do not have it
    before, silent = settings.get(), settings.get()
    silent.logto_console = silent.logto_file = False
    settings.set(silent)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            yield
    finally:
        settings.set(before)


def _lever(quadrotor: Quadrotor) -> float:
    """[m] of a rotor in the mean, about the axes of roll and pitch: of an X that of every rotor."""
    return float(np.linalg.norm(quadrotor.torque_matrix[0]) / 2)


def _mixing(quadrotor: Quadrotor) -> Floats:
    """Signs of the rotors' torques, shape (3, 4): crazyflow's lever and torque ratio times them are torques.

    Raises:
        SimulatorError: crazyflow's mixer, which takes the transposed matrix for the inverse, does not fit the rotors.
    """
    lever = _lever(quadrotor)
    mixing = quadrotor.torque_matrix / np.array([lever, lever, quadrotor.torque_ratio])[:, None]
    if mixing.shape != (3, 4) or not np.allclose(mixing @ mixing.T, 4 * np.eye(3), atol=1e-6):
        raise SimulatorError(f"crazyflow flies four rotors in a square, not those of {quadrotor.name}")
    return mixing


def _controllers(vehicle: Quadrotor, autopilot: Quadrotor, curve: Floats) -> tuple[dict[str, Any], dict[str, Any]]:
    """Parameters of crazyflow's rate loop and of its mixer, so that torque = J k (w_cmd - w)."""
    least, largest = vehicle.rotor_thrust
    newton = largest / PWM  # of a unit of its PWM
    mixing, lever, ratio = _mixing(autopilot), _lever(autopilot), autopilot.torque_ratio
    per_unit = newton * np.array([2 * lever, 2 * lever, 4 * ratio])
    common = {"thrust_max": largest, "L": lever, "thrust2torque": ratio, "mixing_matrix": jnp.array(mixing)}
    rates = common | {
        "kR": jnp.zeros(3),
        "kw": jnp.array(np.array(vehicle.rate_gain) * autopilot.inertia_vector / per_unit),
        "ki_m": jnp.zeros(3),
        "kd_omega": jnp.zeros(3),
        "int_err_max": jnp.ones(3),
        "torque_pwm_max": jnp.full(3, NO_LIMIT),
        "pwm_min": least / newton,
        "pwm_max": PWM,
    }
    return rates, common | {"thrust_min": least, "rpm2thrust": jnp.array(curve)}


def _set_controllers(sim: Sim, rates: dict[str, Any], mixer: dict[str, Any]) -> None:
    """Give crazyflow's rate loop and its mixer other parameters."""
    c = sim.data.controls
    c = c.replace(body_rate=c.body_rate.replace(params=rates), force_torque=c.force_torque.replace(params=mixer))
    sim.data = sim.data.replace(controls=c)


def _drag(data: SimData) -> SimData:
    """Crazyflow's data with the force (world) of the drags that it has none of: of the rotors, and quadratic; held for a step."""
    attitude, states = Rotation.from_quat(data.states.quat), data.states
    air = attitude.apply(states.vel, inverse=True)
    speeds = jnp.sqrt(data.params.rpm2thrust[..., 2]) * jnp.sum(states.rotor_vel, axis=-1, keepdims=True)
    force = data.plugins[ROTOR_DRAG] * speeds * air + data.plugins[BODY_DRAG] * air * jnp.abs(air)
    return data.replace(states=states.replace(force=-attitude.apply(force)))


def _integrate(data: SimData) -> SimData:
    return rk4(data, first_principles_dynamics)
