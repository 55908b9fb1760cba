"""The plant registry: the functions that simulate each kind of vehicle. The plain plant is compiled as if there were no other."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.flight.detailed_plant import allocate_detailed_state, detailed_autopilot_numbers, detailed_functions, detailed_vehicle_numbers
from hotlap.flight.numbers import COMPILE
from hotlap.flight.plant import VehicleState, allocate_vehicle_state, autopilot_numbers, fly_period, vehicle_numbers
from hotlap.race.plant_kind import PLAIN, detailed_kind, plant_kind_of
from hotlap.race.quadrotor import Quadrotor

Floats = NDArray[np.float64]


class PlantFunctions(NamedTuple):
    """The functions of one kind of plant, compiled by Numba; its memory is a named tuple of arrays that has all of `VehicleState`.

    Attributes:
        settle: (memory, lane): makes a lane ready for a flight, whose body is placed and whose rotors hover as four do.
        fly_period: (memory as numbers, steps): flies one control period.
    """

    settle: Any
    fly_period: Any


@njit(**COMPILE)
def _stay(vehicle_state: VehicleState, k: int) -> None:
    """Nothing: four rotors hover already."""


@cache
def plant_functions(kind: str) -> PlantFunctions:
    """The functions of a kind of plant."""
    return PlantFunctions(_stay, fly_period) if kind == PLAIN else PlantFunctions(*detailed_functions(kind))


def allocator(vehicle: Quadrotor) -> Callable[[int, type[np.floating[Any]]], Any]:
    """(lanes, kind of float) -> raw memory of the plant of a vehicle."""
    kind = plant_kind_of(vehicle)
    return allocate_vehicle_state if kind == PLAIN else partial(allocate_detailed_state, detailed_kind(kind), vehicle.rate_delay)


def plant_numbers(vehicle_parameters: Floats, vehicle: Quadrotor, control_model: Quadrotor) -> tuple[Floats, Floats]:
    """The numbers that the plant of a vehicle computes with.

    Args:
        vehicle_parameters: shape (B, P).
        vehicle: what flies.
        control_model: the vehicle as its rate loop knows it, with as many rotors.

    Returns:
        Those of the vehicle, shape (B, V), and those of the rate loop, shape (A,).

    Raises:
        HotlapError: a physical parameter is impossible.
    """
    if plant_kind_of(vehicle) == PLAIN:
        return vehicle_numbers(vehicle_parameters, vehicle.layout), autopilot_numbers(control_model)
    return detailed_vehicle_numbers(vehicle_parameters, vehicle), detailed_autopilot_numbers(control_model, vehicle)
