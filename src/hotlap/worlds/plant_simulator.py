"""PlantSimulator: the built-in world's plant, step by step, as a simulator: a base for one's own, and what `Stepped` is tested with."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.flight.kernel_cache import keep
from hotlap.flight.lanes import as_numbers, borrow
from hotlap.flight.numbers import COMPILE
from hotlap.flight.plant import THRUST_FACTOR, VehicleState, allocate_vehicle_state, autopilot_numbers, fly_period, vehicle_numbers
from hotlap.flight.verdicts import TAKEN_OFF
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import PLANT_STEP
from hotlap.race.vehicle_parameters import vehicle_parameters_of
from hotlap.worlds.simulator import Start

Floats = NDArray[np.float64]


class PlantSimulator:
    """Simulates quadrotors as the built-in world does, dead time and wind apart; a `Simulator`.

    Args:
        quadrotor: that flies.
        known_as: the quadrotor as its rate loop knows it; None: as it is.
        floor: [m] on which a drone stands that has not taken off.
        lanes: drones that are flown at once.
    """

    step, scales_thrust = PLANT_STEP, True

    def __init__(self, quadrotor: Quadrotor, known_as: Quadrotor | None = None, floor: float = -math.inf, lanes: int = 1) -> None:
        self.lanes, self._floor = lanes, floor
        self._hover = math.sqrt(quadrotor.mass * (known_as or quadrotor).gravity / 4)
        self._grounded = np.zeros(lanes, dtype=bool)
        self._drones = [allocate_vehicle_state(1, np.float64) for _ in range(lanes)]
        for drone in self._drones:
            drone.vehicle[:, 0] = vehicle_numbers(vehicle_parameters_of(quadrotor)[None], quadrotor.layout)[0]
            drone.autopilot[:, 0] = autopilot_numbers(known_as or quadrotor)
            drone.disturbance[THRUST_FACTOR], drone.step[:] = 1, PLANT_STEP

    def reset(self, lane: int, start: Start) -> None:
        """Place a drone, its rotors as in hover."""
        drone = self._drones[lane]
        drone.state[:13, 0], drone.state[13:, 0] = start.state, self._hover
        drone.disturbance[THRUST_FACTOR, 0] = start.thrust_factor
        self._grounded[lane] = start.state[2] <= self._floor + TAKEN_OFF

    def advance(self, commands: Floats, duration: float) -> None:
        """Fly all lanes for a duration [s] under commands that are held, shape (L, 4)."""
        steps = round(duration / PLANT_STEP)
        for lane, (drone, command) in enumerate(zip(self._drones, commands, strict=True)):
            drone.acting[:, 0] = command
            _fly(drone, steps)
            if self._grounded[lane]:
                self._stand(lane)

    def states(self) -> Floats:
        """Position, attitude, velocity and body rates, shape (L, 13)."""
        return np.array([drone.state[:13, 0] for drone in self._drones])

    def rotor_thrusts(self) -> Floats:
        """Shape (L, 4) [N]."""
        return np.array([drone.state[13:, 0] ** 2 for drone in self._drones])

    def close(self) -> None:
        """Nothing is held."""

    def _stand(self, lane: int) -> None:
        """Keep a drone on the ground until it takes off."""
        state = self._drones[lane].state
        if state[2, 0] < self._floor:
            state[2, 0], state[9, 0] = self._floor, max(float(state[9, 0]), 0.0)
        self._grounded[lane] = state[2, 0] <= self._floor + TAKEN_OFF


def _period(vehicle: VehicleState, steps: int) -> None:
    """Fly so many steps under one command."""
    fly_period(as_numbers(borrow(vehicle), 0), steps)


_fly = keep(njit(**COMPILE)(_period), "one-period")
