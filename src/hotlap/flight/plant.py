"""The vehicle as the flight core takes it: its physical parameters as numbers, and a control period of flight."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.dynamics_layout import AUTOPILOT, DISTURBANCE, MODEL, VEHICLE
from hotlap.errors import HotlapError
from hotlap.flight.compile import compiled_dynamics
from hotlap.flight.lanes import select
from hotlap.flight.numbers import COMPILE, aligned_zeros
from hotlap.quadrotor import Layout, Quadrotor, torque_matrix
from hotlap.race import PLANT_STEP
from hotlap.truth import TRUTH

Floats = NDArray[np.float64]

step_plant = compiled_dynamics("plant_step")


def vehicle_numbers(truth: Floats, layout: Layout) -> Floats:
    """What `dynamics.plant_step` takes for the vehicle.

    Args:
        truth: shape (B, P).
        layout: of the rotors.

    Returns:
        Shape (B, V), in the order of `dynamics_layout.VEHICLE`.

    Raises:
        HotlapError: a physical parameter is not finite or negative, or a mass or inertia is 0.
    """
    if truth.ndim != 2 or truth.shape[1] != len(TRUTH):
        raise HotlapError(f"truth must have the columns {', '.join(TRUTH)}, not shape {truth.shape}")
    bad = ~(np.isfinite(truth) & (truth >= 0)) | ((truth == 0) & (np.arange(len(TRUTH)) < 6))
    if bad.any():
        row, column = np.argwhere(bad)[0]
        raise HotlapError(f"truth[{row}]: {TRUTH[column]} cannot be {truth[row, column]:g}")
    unit_arm, unit_ratio = torque_matrix(layout, 1.0, 0.0), torque_matrix(layout, 0.0, 1.0)
    torques = truth[:, 4, None, None] * unit_arm + truth[:, 5, None, None] * unit_ratio
    with np.errstate(divide="ignore"):
        shares = 1 - np.exp(-PLANT_STEP / truth[:, 8:10])  # a motor time of 0 follows at once
    parts = [truth[:, :4], torques.reshape(len(truth), 12), truth[:, 6:8], shares, truth[:, 10:17], truth[:, 22:], truth[:, 17:21]]
    return np.hstack(parts)


def autopilot_numbers(believed: Quadrotor) -> Floats:
    """What `dynamics.plant_step` takes for the rate loop, shape (A,): mass, inertia and mixer of what it takes the vehicle for."""
    mixer = np.linalg.inv(np.vstack([np.ones(4), believed.torque_matrix]))
    return np.concatenate([[believed.mass], believed.inertia_vector, mixer.ravel()])


def model_numbers(believed: Quadrotor) -> Floats:
    """What a controller's own model is given, shape (M,), in the order of `dynamics_layout.MODEL`."""
    return np.concatenate([np.atleast_1d(getattr(believed, name)) for name in MODEL])


class Craft(NamedTuple):
    """Memory of a vehicle in flight; raw floats (..., lanes), or numbers (...).

    Attributes:
        state: (17,) p q v w, square roots of the rotor thrusts.
        moved: (17,) the same, a step later.
        before: (3,) position at the beginning of the period.
        acting: (4,) command that is acting, noise included.
        older: (4,) the one before it.
        command: (4,) of the present step.
        older_steps: (1,) how many steps of each period the older one still acts.
        vehicle, autopilot, disturbance: as in `dynamics.plant_step`.
        step: (1,) [s].
    """

    state: Any
    moved: Any
    before: Any
    acting: Any
    older: Any
    command: Any
    older_steps: Any
    vehicle: Any
    autopilot: Any
    disturbance: Any
    step: Any


VEHICLE_SIZE, AUTOPILOT_SIZE = sum(VEHICLE.values()), sum(AUTOPILOT.values())
DISTURBANCE_SIZE = sum(DISTURBANCE.values())


def allocate_craft(lanes: int, kind: type[np.floating[Any]]) -> Craft:
    """Raw memory, of one kind of float; what a lane without a flight computes with is 1."""
    sizes = (17, 17, 3, 4, 4, 4, 1, VEHICLE_SIZE, AUTOPILOT_SIZE, DISTURBANCE_SIZE, 1)
    memory = Craft(*(aligned_zeros((size, lanes), kind) for size in sizes))
    for array in (memory.state[3], memory.vehicle, memory.autopilot):
        array.fill(1)
    return memory


@njit(**COMPILE)
def fly_period(craft: Craft, steps: int) -> None:
    """Fly one control period of so many steps; at its beginning the older command still acts."""
    for i in range(3):
        craft.before[i] = craft.state[i]
    for s in range(steps):
        is_older = craft.older_steps[0] > s
        for a in range(4):
            craft.command[a] = select(is_older, craft.older[a], craft.acting[a])
        step_plant(craft.state, craft.command, craft.vehicle, craft.autopilot, craft.disturbance, craft.step, craft.moved)
        for i in range(17):
            craft.state[i] = craft.moved[i]
