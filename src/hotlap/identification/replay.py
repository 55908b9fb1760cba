"""Replay: the built-in world's vehicle under commands that were logged; how it turns and pushes does not depend on where it is."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from hotlap.core.records import Floats
from hotlap.flight.kernel_cache import keep
from hotlap.flight.lanes import as_numbers, borrow
from hotlap.flight.numbers import COMPILE
from hotlap.flight.plant import THRUST_FACTOR, VehicleState
from hotlap.flight.plants import allocator, plant_functions, plant_numbers
from hotlap.race.plant_kind import PLAIN, plant_kind_of
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import PLANT_STEP
from hotlap.race.vehicle_parameters import vehicle_parameters_of

RATES, THRUST, ROOTS = slice(0, 3), 3, 4


def replay(quadrotor: Quadrotor, commands: Floats) -> Floats:
    """Fly commands, from level and still, in hover.

    Args:
        quadrotor: that flies; its dead time does not count.
        commands: shape (N, 4): thrust per mass [m/s^2] and body rates [rad/s] in each step of the plant.

    Returns:
        Shape (N + 1, 5): body rates [rad/s], thrust per mass [m/s^2] and the sum of the square roots of the rotor thrusts [N^0.5]
        before the first step and after each.
    """
    drone = allocator(quadrotor)(1, np.float64)
    vehicle, autopilot = plant_numbers(vehicle_parameters_of(quadrotor)[None], quadrotor, quadrotor)
    drone.vehicle[:, 0], drone.autopilot[:, 0] = vehicle[0], autopilot
    drone.disturbance[THRUST_FACTOR], drone.step[:] = 1, PLANT_STEP
    drone.state[:13, 0], drone.state[3, 0] = 0.0, 1.0
    drone.state[13:, 0] = math.sqrt(quadrotor.mass * quadrotor.gravity / 4)
    rows = np.empty((len(commands) + 1, 5))
    _replayed(plant_kind_of(quadrotor))(drone, np.ascontiguousarray(commands), quadrotor.rotor_count, quadrotor.mass, rows)
    return rows


@cache
def _replayed(kind: str) -> Any:
    """The compiled function for a kind of plant."""
    plant = plant_functions(kind)
    settle, fly_period = plant.settle, plant.fly_period

    def fly(vehicle: VehicleState, commands: Floats, rotors: int, mass: float, rows: Floats) -> None:
        """Fill the rows of `replay`."""
        settle(vehicle, 0)
        for k in range(len(commands) + 1):
            if k:
                for a in range(4):
                    vehicle.acting[a, 0] = commands[k - 1, a]
                fly_period(as_numbers(borrow(vehicle), 0), 1)
            for i in range(3):
                rows[k, i] = vehicle.state[10 + i, 0]
            thrust, roots = 0.0, 0.0
            for n in range(13, 13 + rotors):
                thrust += vehicle.state[n, 0] ** 2
                roots += vehicle.state[n, 0]
            rows[k, 3], rows[k, 4] = thrust / mass, roots

    from numba import njit  # noqa: PLC0415  the flight core has to start it

    return keep(njit(**COMPILE)(fly), "identify-replay" + ("" if kind == PLAIN else f"-{kind}"))
