"""Vehicle parameters: the physical parameters of a quadrotor as numbers, one row a flight, and random vehicles around them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import HotlapError
from hotlap.race.quadrotor import Quadrotor

Floats = NDArray[np.float64]

COLUMNS: Mapping[str, tuple[str, ...]] = {
    "mass": ("mass",),
    "inertia": ("inertia_x", "inertia_y", "inertia_z"),
    "arm": ("arm",),
    "torque_ratio": ("torque_ratio",),
    "rotor_thrust": ("rotor_thrust_min", "rotor_thrust_max"),
    "motor_time": ("motor_time_up", "motor_time_down"),
    "drag": ("drag_x", "drag_y", "drag_z"),
    "rotor_drag": ("rotor_drag",),
    "body_drag": ("body_drag_x", "body_drag_y", "body_drag_z"),
    "rate_gain": ("rate_gain_x", "rate_gain_y", "rate_gain_z"),
    "torque_damping": ("torque_damping",),
    "delay": ("delay",),
    "gravity": ("gravity",),
    "sag": ("sag",),
    "charge_sag": ("charge_sag",),
}
"""Names of the numbers that each physical parameter of `Quadrotor` consists of."""

VEHICLE_PARAMETERS = tuple(name for names in COLUMNS.values() for name in names)
"""Columns of `vehicle_parameters` in `World.fly`: what may differ from flight to flight, in the units of `Quadrotor`."""

NEVER_ZERO = ("mass", "inertia", "arm", "torque_ratio")

MASSES = ("mass", "inertia_x", "inertia_y", "inertia_z")
DRAGS = ("drag_x", "drag_y", "drag_z", "rotor_drag", "body_drag_x", "body_drag_y", "body_drag_z")
FORCES = (*MASSES, *DRAGS[3:])  # thrust that is stronger by a factor is the same as these being smaller by it

UNCERTAIN: Mapping[str, tuple[str, ...]] = {
    "mass": MASSES,
    "thrust": FORCES,
    "motor lag": ("motor_time_up", "motor_time_down"),
    "drag": DRAGS,
    "dead time": ("delay",),
}
"""What is uncertain about a vehicle, and the columns of `VEHICLE_PARAMETERS` that it multiplies; more thrust divides them."""


def vehicle_parameters_of(quadrotor: Quadrotor) -> Floats:
    """The physical parameters of a quadrotor, shape (P,), in the order of `VEHICLE_PARAMETERS`."""
    parts = ((names, np.ravel(getattr(quadrotor, part))) for part, names in COLUMNS.items())
    values = {name: number for names, numbers in parts for name, number in zip(names, numbers, strict=True)}
    return np.array([values[name] for name in VEHICLE_PARAMETERS])


def check_vehicle_parameters(vehicle_parameters: Floats) -> None:
    """Refuse rows of vehicle parameters that no vehicle has.

    Raises:
        HotlapError: the shape is not (B, P); a number is not finite or is negative; a mass, an inertia, an arm or a torque ratio is 0.
    """
    if vehicle_parameters.ndim != 2 or vehicle_parameters.shape[1] != len(VEHICLE_PARAMETERS):
        raise HotlapError(f"vehicle_parameters must have the columns {', '.join(VEHICLE_PARAMETERS)}, not shape {vehicle_parameters.shape}")
    bad = ~(np.isfinite(vehicle_parameters) & (vehicle_parameters >= 0))
    bad |= (vehicle_parameters == 0) & np.isin(VEHICLE_PARAMETERS, [name for part in NEVER_ZERO for name in COLUMNS[part]])
    if bad.any():
        row, column = np.argwhere(bad)[0]
        raise HotlapError(f"vehicle_parameters[{row}]: {VEHICLE_PARAMETERS[column]} cannot be {vehicle_parameters[row, column]:g}")


def part_of(vehicle_parameters: Floats, part: str) -> Floats:
    """The columns of one physical parameter of `Quadrotor`, by its name, shape (..., 1) or what the parameter consists of."""
    return vehicle_parameters[..., [VEHICLE_PARAMETERS.index(name) for name in COLUMNS[part]]]


def scale(vehicle_parameters: Floats, names: tuple[str, ...], factor: float | Floats) -> Floats:
    """Rows of vehicle parameters, shape (..., P), with some columns multiplied."""
    changed = vehicle_parameters.copy()
    columns = [VEHICLE_PARAMETERS.index(name) for name in names]
    changed[..., columns] *= np.asarray(factor)[..., None]
    return changed


def draw_vehicle_parameters(quadrotor: Quadrotor, seeds: NDArray[np.int64], spread: float) -> Floats:
    """A vehicle for each seed: each of `UNCERTAIN` multiplied by a factor of its own, uniform in [1 - spread, 1 + spread].

    Args:
        quadrotor: that they are drawn around.
        seeds: shape (B,); the same seed is the same vehicle.
        spread: 0 to below 1.

    Returns:
        Shape (B, P).
    """
    draws = np.array([np.random.default_rng((int(seed), len(UNCERTAIN))).uniform(-1, 1, len(UNCERTAIN)) for seed in seeds])
    rows = np.tile(vehicle_parameters_of(quadrotor), (len(seeds), 1))
    for (what, names), draw in zip(UNCERTAIN.items(), draws.reshape(-1, len(UNCERTAIN)).T, strict=True):
        factors = 1 + spread * draw
        rows = scale(rows, names, 1 / factors if what == "thrust" else factors)
    return rows
