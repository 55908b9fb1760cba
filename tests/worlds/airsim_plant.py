"""The built-in plant in steps of AirSim's physics, behind a rate loop that waits as AirSim's does."""

from __future__ import annotations

from collections import deque

import numpy as np
from numba import njit

from hotlap.dynamics.parameter_layout import VEHICLE, place_of
from hotlap.files.descriptions import load_quadrotor
from hotlap.flight.kernel_cache import keep
from hotlap.flight.lanes import as_numbers, borrow
from hotlap.flight.numbers import COMPILE
from hotlap.flight.plant import THRUST_FACTOR, VehicleState, allocate_vehicle_state, autopilot_numbers, fly_period, vehicle_numbers
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.vehicle_parameters import vehicle_parameters_of

PROPORTIONAL = {"rate_loop": None, "mixer": "clip", "motor_lag": "speed", "rate_delay": 0.0}  # in place of SimpleFlight, what comes
FITTED = {"rate_gain": (100.0, 84.0, 3.9), "motor_time": (0.01, 0.01)}  # nearest to its steps: 1/s, s
AIRSIM = Quadrotor(**{**load_quadrotor("airsim-122m").model_dump(), **PROPORTIONAL, **FITTED})
STEP, PARTS = 0.003, 2  # s, and into how many the plant divides it
SHARES = place_of("motor_shares", VEHICLE)


class Plant:
    """One drone.

    Args:
        quadrotor: that flies.
        delayed: whether commands wait for its dead time.
    """

    def __init__(self, quadrotor: Quadrotor, *, delayed: bool) -> None:
        self.quadrotor, self._wait = quadrotor, round(quadrotor.delay * PARTS / STEP) if delayed else 0
        self._drone = allocate_vehicle_state(1, np.float64)
        self._drone.vehicle[:, 0] = vehicle_numbers(vehicle_parameters_of(quadrotor)[None], quadrotor.layout)[0]
        times = np.maximum(quadrotor.motor_time, 1e-9)
        self._drone.vehicle[SHARES : SHARES + 2, 0] = 1 - np.exp(-STEP / PARTS / times)
        self._drone.autopilot[:, 0] = autopilot_numbers(quadrotor)
        self._queue: deque[np.ndarray] = deque()
        self._drone.disturbance[THRUST_FACTOR], self._drone.step[:] = 1, STEP / PARTS
        self.stop()

    @property
    def state(self) -> np.ndarray:
        return self._drone.state[:13, 0].copy()

    @state.setter
    def state(self, state: np.ndarray) -> None:
        self._drone.state[:13, 0] = state

    @property
    def rotor_thrusts(self) -> np.ndarray:
        return self._drone.state[13:, 0] ** 2

    def stop(self) -> None:
        """Stand at the origin, rotors at rest."""
        self._drone.state[:, 0] = 0
        self._drone.state[3, 0] = 1
        self._queue = deque([np.zeros(4)] * self._wait)

    def stand(self) -> None:
        """Stand on the ground rather than fall through it."""
        if self._drone.state[2, 0] < 0:
            self._drone.state[2, 0] = self._drone.state[9, 0] = 0

    def step(self, command: np.ndarray) -> None:
        """Fly one step under a command, thrust per mass and body rates."""
        for _ in range(PARTS):
            self._queue.append(command)
            self._drone.acting[:, 0] = self._queue.popleft()
            _fly(self._drone, 1)


def _steps(vehicle: VehicleState, steps: int) -> None:
    fly_period(as_numbers(borrow(vehicle), 0), steps)


_fly = keep(njit(**COMPILE)(_steps), "airsim-plant")
