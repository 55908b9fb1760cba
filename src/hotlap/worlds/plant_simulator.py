"""PlantSimulator: the built-in world's plant, step by step, as a simulator: a base for one's own, and what `Stepped` is tested with."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.flight.kernel_cache import keep
from hotlap.flight.lanes import as_numbers, borrow
from hotlap.flight.numbers import COMPILE
from hotlap.flight.plant import THRUST_FACTOR, VehicleState
from hotlap.flight.plants import allocator, plant_functions, plant_numbers
from hotlap.flight.verdicts import TAKEN_OFF
from hotlap.race.plant_kind import PLAIN, plant_kind_of
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
        known = known_as or quadrotor
        self.lanes, self._floor, self._rotors = lanes, floor, quadrotor.rotor_count
        self._hover = math.sqrt(quadrotor.mass * known.gravity / 4)
        self._grounded = np.zeros(lanes, dtype=bool)
        self._settle, self._fly = _functions(plant_kind_of(quadrotor))
        self._drones = [allocator(quadrotor)(1, np.float64) for _ in range(lanes)]
        vehicle, autopilot = plant_numbers(vehicle_parameters_of(quadrotor)[None], quadrotor, known)
        for drone in self._drones:
            drone.vehicle[:, 0], drone.autopilot[:, 0] = vehicle[0], autopilot
            drone.disturbance[THRUST_FACTOR], drone.step[:] = 1, PLANT_STEP

    def reset(self, lane: int, start: Start) -> None:
        """Place a drone, its rotors as in hover."""
        drone = self._drones[lane]
        drone.state[:13, 0], drone.state[13:, 0] = start.state, self._hover
        self._settle(drone, 0)
        drone.disturbance[THRUST_FACTOR, 0] = start.thrust_factor
        self._grounded[lane] = start.state[2] <= self._floor + TAKEN_OFF

    def advance(self, commands: Floats, duration: float) -> None:
        """Fly all lanes for a duration [s] under commands that are held, shape (L, 4)."""
        steps = round(duration / PLANT_STEP)
        for lane, (drone, command) in enumerate(zip(self._drones, commands, strict=True)):
            drone.acting[:, 0] = command
            self._fly(drone, steps)
            if self._grounded[lane]:
                self._stand(lane)

    def states(self) -> Floats:
        """Position, attitude, velocity and body rates, shape (L, 13)."""
        return np.array([drone.state[:13, 0] for drone in self._drones])

    def rotor_thrusts(self) -> Floats:
        """Shape (L, rotors) [N]."""
        return np.array([drone.state[13 : 13 + self._rotors, 0] ** 2 for drone in self._drones])

    def close(self) -> None:
        """Nothing is held."""

    def _stand(self, lane: int) -> None:
        """Keep a drone on the ground until it takes off."""
        state = self._drones[lane].state
        if state[2, 0] < self._floor:
            state[2, 0], state[9, 0] = self._floor, max(float(state[9, 0]), 0.0)
        self._grounded[lane] = state[2, 0] <= self._floor + TAKEN_OFF


@cache
def _functions(kind: str) -> tuple[Any, Any]:
    """Two compiled functions of a kind of plant: make a drone ready for a flight, and fly so many steps under one command."""
    from numba import njit  # noqa: PLC0415  the flight core starts it

    plant = plant_functions(kind)
    settle, fly_period, name = plant.settle, plant.fly_period, "" if kind == PLAIN else f"-{kind}"

    def settle_one(vehicle: VehicleState, lane: int) -> None:
        """Rotors hover, and the rate loop remembers rest."""
        settle(vehicle, lane)

    def period(vehicle: VehicleState, steps: int) -> None:
        """Fly so many steps under one command."""
        fly_period(as_numbers(borrow(vehicle), 0), steps)

    return keep(njit(**COMPILE)(settle_one), f"one-settle{name}"), keep(njit(**COMPILE)(period), f"one-period{name}")
