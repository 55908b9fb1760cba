"""RotorPy (github.com/spencerfolk/rotorpy, MIT): a quadrotor with aerodynamics, in Python, a few times faster than real time."""

from __future__ import annotations

import math
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hotlap.race.quadrotor import Quadrotor
from hotlap.reference.scenario import Scenario
from hotlap.worlds.separate import Separate
from hotlap.worlds.simulator import Simulator, SimulatorError, Start

if TYPE_CHECKING:
    from rotorpy.vehicles.multirotor import Multirotor

Floats = NDArray[np.float64]

MISSING = "rotorpy is not installed: pip install 'hotlap[rotorpy]'"
STEP = 0.0025  # s: its rate loop runs once a step
THRUST_CURVE = 1e-6  # N/(rad/s)^2: any will do, as only thrusts are given
LEAST_MOTOR_TIME = 1e-3  # s, so that its integrator need not be stiff


def open_simulator(scenario: Scenario, instance: int, argument: str = "") -> Simulator:
    """A RotorPy for each instance: the first one in this process, each other one in a process of its own.

    Raises:
        SimulatorError: RotorPy is not installed, or an argument was given.
    """
    if argument:
        raise SimulatorError(f"rotorpy takes no argument, not '{argument}'")
    described = scenario.race.vehicle, scenario.race.control_model
    return Separate(RotorPy, *described) if instance else RotorPy(*described)


def installed() -> bool:
    """Whether RotorPy is there."""
    return find_spec("rotorpy") is not None


class RotorPy:
    """One quadrotor in RotorPy, with its aerodynamics and its rate loop ("cmd_ctbr").

    Args:
        vehicle: that flies. Dead time and battery are not RotorPy's.
        autopilot: whose mass, inertia and mixer the rate loop takes to be true; None: the vehicle's.

    Attributes:
        lanes: 1.
        step: [s].
        scales_thrust: True.

    Raises:
        SimulatorError: RotorPy is not installed, or the vehicle has not four rotors.
    """

    def __init__(self, vehicle: Quadrotor, autopilot: Quadrotor | None = None) -> None:
        self.lanes, self.step, self.scales_thrust = 1, STEP, True
        self._vehicle, self._mass = vehicle, (autopilot or vehicle).mass
        self._multirotor: Any = multirotor(vehicle, autopilot or vehicle)
        self._state: dict[str, Floats] = {}
        self.reset(0, Start(np.array([0.0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0])))

    def reset(self, lane: int, start: Start) -> None:
        """Place the drone, its rotors as in hover."""
        del lane
        hover = np.sqrt(self._vehicle.mass * self._vehicle.gravity / 4 / THRUST_CURVE)
        w, *xyz = start.state[3:7]
        self._multirotor.thrust_factor = start.thrust_factor
        self._state = {
            "x": start.state[:3].copy(),
            "v": start.state[7:10].copy(),
            "q": np.array([*xyz, w]),
            "w": start.state[10:13].copy(),
            "wind": np.zeros(3),
            "rotor_speeds": np.full(4, hover),
        }

    def advance(self, commands: Floats, duration: float) -> None:
        """Fly for a duration [s] under a command, shape (1, 4)."""
        thrust, *rates = commands[0]
        command = {"cmd_thrust": self._mass * thrust, "cmd_w": np.array(rates)}
        for _ in range(round(duration / STEP)):
            self._state = self._multirotor.step(self._state, command, STEP)

    def states(self) -> Floats:
        """Where the drone is, shape (1, 13)."""
        x, y, z, w = self._state["q"]
        return np.concatenate([self._state["x"], [w, x, y, z], self._state["v"], self._state["w"]])[None]

    def rotor_thrusts(self) -> Floats:
        """What the rotors give, shape (1, 4) [N]."""
        return THRUST_CURVE * self._state["rotor_speeds"][None] ** 2

    def close(self) -> None:
        """It holds nothing."""


def parameters_of(vehicle: Quadrotor) -> dict[str, Any]:
    """A quadrotor as RotorPy describes one."""
    least, largest = np.sqrt(np.array(vehicle.rotor_thrust) / THRUST_CURVE)
    inertia = dict(zip(("Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"), (*vehicle.inertia, 0.0, 0.0, 0.0), strict=True))
    return {
        "mass": vehicle.mass,
        **inertia,
        **dict.fromkeys(("c_Dx", "c_Dy", "c_Dz"), 0.0),  # its form takes the whole speed for every axis: see `multirotor`
        "num_rotors": 4,
        "rotor_pos": {f"r{k + 1}": np.array([*position, 0.0]) for k, position in enumerate(vehicle.rotor_positions)},
        "rotor_directions": vehicle.rotor_spins,
        "rotor_speed_min": float(least),
        "rotor_speed_max": float(largest),
        "k_eta": THRUST_CURVE,
        "k_m": THRUST_CURVE * vehicle.torque_ratio,
        "k_d": vehicle.rotor_drag * np.sqrt(THRUST_CURVE),
        "k_z": vehicle.inflow * np.sqrt(THRUST_CURVE),
        "tau_m": max(*vehicle.motor_time, LEAST_MOTOR_TIME),
        "k_w": np.array(vehicle.rate_gain),
    }


def multirotor(vehicle: Quadrotor, autopilot: Quadrotor) -> Multirotor:
    """RotorPy's quadrotor, made ours: other time constants up and down, drags axis by axis, thrust that is off by a factor.

    Args:
        vehicle: that flies.
        autopilot: whose inertia and mixer its rate loop takes to be true.

    Raises:
        SimulatorError: RotorPy is not installed, or the vehicle has not four rotors.
    """
    if vehicle.rotor_count != 4:
        raise SimulatorError(f"rotorpy flies four rotors, not the {vehicle.rotor_count} of {vehicle.name}")
    try:
        from rotorpy.vehicles.multirotor import Multirotor  # noqa: PLC0415  optional, and takes a second
    except ModuleNotFoundError as error:
        raise SimulatorError(MISSING) from error

    up, down = (max(time, LEAST_MOTOR_TIME) for time in vehicle.motor_time)
    linear_drag, body_drag = vehicle.mass * np.array(vehicle.drag), np.array(vehicle.body_drag)

    class Ours(Multirotor):
        """A quadrotor that RotorPy flies."""

        thrust_factor = 1.0

        def get_cmd_motor_speeds(self, state: dict[str, Floats], control: dict[str, Any]) -> Floats:
            """Rotor speeds that the rate loop asks for; the motors take the time constant of the direction in which each will go."""
            asked = super().get_cmd_motor_speeds(state, control)
            self.tau_m = np.where(asked > state["rotor_speeds"], up, down)
            return asked

        def step(self, state: dict[str, Floats], control: dict[str, Any], t_step: float) -> dict[str, Floats]:
            """The state after a step by Kutta's rule of third order: as with RotorPy's own integrator to 1e-4, in a third of the time."""
            asked = np.clip(self.get_cmd_motor_speeds(state, control), self.rotor_speed_min, self.rotor_speed_max)
            s = self._pack_state(state)
            first = self._s_dot_fn(0.0, s, asked)
            second = self._s_dot_fn(0.0, s + t_step / 2 * first, asked)
            third = self._s_dot_fn(0.0, s + t_step * (2 * second - first), asked)
            after = self._unpack_state(s + t_step / 6 * (first + 4 * second + third))
            after["q"] /= math.sqrt(after["q"] @ after["q"])
            after["rotor_speeds"].clip(self.rotor_speed_min, self.rotor_speed_max, out=after["rotor_speeds"])
            return after

        def compute_body_wrench(self, body_rates: Floats, rotor_speeds: Floats, body_airspeed_vector: Floats) -> tuple[Floats, Floats]:
            """Force and torque (body)."""
            force, torque = super().compute_body_wrench(body_rates, rotor_speeds, body_airspeed_vector)
            force = force - (linear_drag + body_drag * np.abs(body_airspeed_vector)) * body_airspeed_vector
            force[2] += (self.thrust_factor - 1) * self.k_eta * (rotor_speeds @ rotor_speeds)
            return force, torque

    made = Ours(parameters_of(vehicle), control_abstraction="cmd_ctbr", aero=True)
    made.g, made.weight = vehicle.gravity, np.array([0.0, 0.0, -vehicle.mass * vehicle.gravity])
    made.k_w = np.array(vehicle.rate_gain) * autopilot.inertia_vector / vehicle.inertia_vector
    made.TM_to_f = np.linalg.inv(np.vstack([np.ones(4), autopilot.torque_matrix]))
    return made
