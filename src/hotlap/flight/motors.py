"""The vehicle behind motor outputs: what a flight controller of one's own, in another process, commands."""

from __future__ import annotations

import math
from importlib import import_module

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.core.errors import HotlapError
from hotlap.flight.compile import compiled, translate
from hotlap.flight.detailed_plant import detailed_vehicle_numbers
from hotlap.flight.kernel_cache import keep
from hotlap.flight.numbers import COMPILE
from hotlap.flight.plant import DISTURBANCE_SIZE, THRUST_FACTOR
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.vehicle_parameters import vehicle_parameters_of

Floats = NDArray[np.float64]

ROTORS = 4
step_rotors = compiled(lambda: translate(import_module("hotlap.dynamics.detailed_plant").detailed_rotor_step(ROTORS)))
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


class MotorPlant:
    """A quadrotor whose motors are driven directly; a rotor's thrust is its largest times the square of its output.

    Args:
        quadrotor: that flies, on four rotors; its rate loop and its dead time do not count.
        step: [s] of the integration.

    Raises:
        HotlapError: it has another number of rotors.

    Attributes:
        state: shape (17,): position [m], attitude (w, x, y, z), velocity [m/s] (world), body rates [rad/s], square roots of the rotor
            thrusts [N^0.5].
        force: shape (3,) [m/s^2] (body): specific force, as accelerometers feel it, in the mean of the last advance.
    """

    def __init__(self, quadrotor: Quadrotor, step: float) -> None:
        if quadrotor.rotor_count != ROTORS:
            raise HotlapError(f"{quadrotor.name} has {quadrotor.rotor_count} rotors, not {ROTORS}")
        self._vehicle = detailed_vehicle_numbers(vehicle_parameters_of(quadrotor)[None], quadrotor, step)[0]
        self._most, self._disturbance, self._step = quadrotor.rotor_thrust[1], np.zeros(DISTURBANCE_SIZE), np.array([step])
        self._gravity, self._hover = quadrotor.gravity, math.sqrt(quadrotor.mass * quadrotor.gravity / 4)
        self._moved = np.zeros(17)
        self.state, self.force = np.zeros(17), np.zeros(3)
        self.place(np.concatenate([np.zeros(3), UPRIGHT, np.zeros(6)]))

    def place(self, state: Floats, thrust_factor: float = 1.0) -> None:
        """Put it somewhere, its rotors as in hover.

        Args:
            state: shape (13,), as the first of `state`.
            thrust_factor: by which thrust differs from what the motors ask for [-].
        """
        self.state[:13], self.state[13:] = state, self._hover
        self.force[:] = 0.0, 0.0, self._gravity
        self._disturbance[THRUST_FACTOR] = thrust_factor

    def advance(self, outputs: Floats, steps: int) -> None:
        """Fly so many steps with motor outputs, shape (4,) [-], 0 to 1, in the order of the layout."""
        _advance(
            self.state, self._moved, outputs, self._most, self._vehicle, self._disturbance, self._step, steps, self._gravity, self.force
        )


def _advance_by(
    state: Floats,
    moved: Floats,
    outputs: Floats,
    most: float,
    vehicle: Floats,
    disturbance: Floats,
    step: Floats,
    steps: int,
    gravity: float,
    force: Floats,
) -> None:
    """Fly so many steps; see `MotorPlant`."""
    asked, before = np.empty(ROTORS), np.empty(3)
    for a in range(ROTORS):
        asked[a] = most * min(max(outputs[a], 0.0), 1.0) ** 2
    for i in range(3):
        before[i] = state[7 + i]
    for _ in range(steps):
        step_rotors(state, asked, vehicle, disturbance, step, moved)
        for i in range(17):
            state[i] = moved[i]
    w, x, y, z = state[3], state[4], state[5], state[6]
    span = steps * step[0]
    a, b, c = (state[7] - before[0]) / span, (state[8] - before[1]) / span, (state[9] - before[2]) / span + gravity
    force[0] = (1 - 2 * (y * y + z * z)) * a + 2 * (x * y + w * z) * b + 2 * (x * z - w * y) * c
    force[1] = 2 * (x * y - w * z) * a + (1 - 2 * (x * x + z * z)) * b + 2 * (y * z + w * x) * c
    force[2] = 2 * (x * z + w * y) * a + 2 * (y * z - w * x) * b + (1 - 2 * (x * x + y * y)) * c


_advance = keep(njit(**COMPILE)(_advance_by), "motors")
