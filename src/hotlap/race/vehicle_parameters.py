"""Vehicle parameters: the physical parameters of a quadrotor as numbers, one row a flight, and random vehicles around them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hotlap.race.quadrotor import Quadrotor

Floats = NDArray[np.float64]

VEHICLE_PARAMETERS = (
    "mass", "inertia_x", "inertia_y", "inertia_z", "arm", "torque_ratio", "rotor_thrust_min", "rotor_thrust_max", "motor_time_up",
    "motor_time_down", "drag_x", "drag_y", "drag_z", "rotor_drag", "body_drag_x", "body_drag_y", "body_drag_z", "rate_gain_x",
    "rate_gain_y", "rate_gain_z", "torque_damping", "delay", "gravity",
)  # fmt: skip
"""Columns of `vehicle_parameters` in `World.fly`: what may differ from flight to flight, in the units of `Quadrotor`."""

MASSES = ("mass", "inertia_x", "inertia_y", "inertia_z")
DRAGS = ("drag_x", "drag_y", "drag_z", "rotor_drag", "body_drag_x", "body_drag_y", "body_drag_z")
FORCES = (*MASSES, *DRAGS[3:])  # what weighs less by a thrust that is stronger at every command: all but the rotors

UNCERTAIN: Mapping[str, tuple[str, ...]] = {
    "mass": MASSES,
    "thrust": FORCES,
    "motor lag": ("motor_time_up", "motor_time_down"),
    "drag": DRAGS,
    "dead time": ("delay",),
}
"""What is not known for certain of a vehicle, and the columns of `VEHICLE_PARAMETERS` that it multiplies; more thrust divides them."""


def vehicle_parameters_of(quadrotor: Quadrotor) -> Floats:
    """The physical parameters of a quadrotor, shape (P,), in the order of `VEHICLE_PARAMETERS`."""
    q = quadrotor
    return np.array([
        q.mass, *q.inertia, q.arm, q.torque_ratio, *q.rotor_thrust, *q.motor_time, *q.drag, q.rotor_drag, *q.body_drag, *q.rate_gain,
        q.torque_damping, q.delay, q.gravity,
    ])  # fmt: skip


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
        seeds: shape (B,); the same seed is the same world.
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
