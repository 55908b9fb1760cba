"""Rate response: how the built-in world's vehicle turns when it is told to, for comparing its rate loop with another."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.dynamics.parameter_layout import DISTURBANCE, VEHICLE, place_of
from hotlap.flight.kernel_cache import keep
from hotlap.flight.numbers import COMPILE
from hotlap.flight.plant import THRUST_FACTOR, autopilot_numbers, step_plant, vehicle_numbers
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import PLANT_STEP
from hotlap.race.vehicle_parameters import vehicle_parameters_of

Floats = NDArray[np.float64]
GAIN = place_of("rate_gain", VEHICLE)


class RateResponse:
    """The built-in world's vehicle under commands that are held, with any rate gain and dead time; it begins level and still, in hover.

    Args:
        quadrotor: that flies.
        commands: shape (N, 4): thrust per mass [m/s^2] and body rates [rad/s].
        steps: of the plant for which each is held.
    """

    def __init__(self, quadrotor: Quadrotor, commands: Floats, steps: int) -> None:
        self._vehicle = vehicle_numbers(vehicle_parameters_of(quadrotor)[None], quadrotor.layout)[0]
        self._autopilot, self._disturbance = autopilot_numbers(quadrotor), np.zeros(sum(DISTURBANCE.values()))
        self._disturbance[THRUST_FACTOR] = 1.0
        self._start = np.zeros(17)
        self._start[3], self._start[13:] = 1.0, math.sqrt(quadrotor.mass * quadrotor.gravity / 4)
        self._hover = np.array([quadrotor.gravity, 0.0, 0.0, 0.0])
        self._commands, self._steps = commands, steps

    def rates(self, gain: Floats, delay_steps: int) -> Floats:
        """Body rates when each command has been held, shape (N, 3) [rad/s].

        Args:
            gain: shape (3,) [1/s] of the rate loop.
            delay_steps: of the plant, from command to rotors.
        """
        self._vehicle[GAIN : GAIN + 3] = gain
        rows = np.empty((len(self._commands), 3))
        state, step = self._start.copy(), np.array([PLANT_STEP])
        numbers = (self._vehicle, self._autopilot, self._disturbance)
        _respond(state, np.zeros(17), self._commands, self._hover, *numbers, step, self._steps, delay_steps, rows)
        return rows


def _fly(
    state: Floats,
    moved: Floats,
    commands: Floats,
    hover: Floats,
    vehicle: Floats,
    autopilot: Floats,
    disturbance: Floats,
    step: Floats,
    steps: int,
    delay_steps: int,
    rows: Floats,
) -> None:
    """Fill `rows`; see `RateResponse.rates`."""
    for k in range(len(commands)):
        for s in range(steps):
            given = k * steps + s - delay_steps
            command = hover if given < 0 else commands[given // steps]
            step_plant(state, command, vehicle, autopilot, disturbance, step, moved)
            for i in range(17):
                state[i] = moved[i]
        for i in range(3):
            rows[k, i] = state[10 + i]


_respond = keep(njit(**COMPILE)(_fly), "rate-response")
