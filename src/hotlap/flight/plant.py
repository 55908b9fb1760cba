"""The vehicle as the flight core takes it: its physical parameters as numbers, and a control period of flight."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.core.errors import HotlapError
from hotlap.dynamics.parameter_layout import AUTOPILOT, DISTURBANCE, MODEL, VEHICLE
from hotlap.flight.compile import compiled_dynamics
from hotlap.flight.lanes import select
from hotlap.flight.numbers import COMPILE, aligned_zeros
from hotlap.race.quadrotor import Quadrotor, RotorLayout, torque_matrix
from hotlap.race.race import PLANT_STEP
from hotlap.race.vehicle_parameters import VEHICLE_PARAMETERS

Floats = NDArray[np.float64]

step_plant = compiled_dynamics("plant_step")


def vehicle_numbers(vehicle_parameters: Floats, layout: RotorLayout) -> Floats:
    """What `dynamics.plant_step` takes for the vehicle.

    Args:
        vehicle_parameters: shape (B, P).
        layout: of the rotors.

    Returns:
        Shape (B, V), in the order of `parameter_layout.VEHICLE`.

    Raises:
        HotlapError: a physical parameter is not finite or negative, or a mass or inertia is 0.
    """
    if vehicle_parameters.ndim != 2 or vehicle_parameters.shape[1] != len(VEHICLE_PARAMETERS):
        raise HotlapError(f"vehicle_parameters must have the columns {', '.join(VEHICLE_PARAMETERS)}, not shape {vehicle_parameters.shape}")
    bad = ~(np.isfinite(vehicle_parameters) & (vehicle_parameters >= 0)) | (
        (vehicle_parameters == 0) & (np.arange(len(VEHICLE_PARAMETERS)) < 6)
    )
    if bad.any():
        row, column = np.argwhere(bad)[0]
        raise HotlapError(f"vehicle_parameters[{row}]: {VEHICLE_PARAMETERS[column]} cannot be {vehicle_parameters[row, column]:g}")
    unit_arm, unit_ratio = torque_matrix(layout, 1.0, 0.0), torque_matrix(layout, 0.0, 1.0)
    torques = vehicle_parameters[:, 4, None, None] * unit_arm + vehicle_parameters[:, 5, None, None] * unit_ratio
    with np.errstate(divide="ignore"):
        shares = 1 - np.exp(-PLANT_STEP / vehicle_parameters[:, 8:10])  # a motor time of 0 follows at once
    parts = [
        vehicle_parameters[:, :4],
        torques.reshape(len(vehicle_parameters), 12),
        vehicle_parameters[:, 6:8],
        shares,
        vehicle_parameters[:, 10:17],
        vehicle_parameters[:, 22:],
        vehicle_parameters[:, 17:21],
    ]
    return np.hstack(parts)


def autopilot_numbers(control_model: Quadrotor) -> Floats:
    """What `dynamics.plant_step` takes for the rate loop, shape (A,): mass, inertia and mixer of what it takes the vehicle for."""
    mixer = np.linalg.inv(np.vstack([np.ones(4), control_model.torque_matrix]))
    return np.concatenate([[control_model.mass], control_model.inertia_vector, mixer.ravel()])


def model_numbers(control_model: Quadrotor) -> Floats:
    """What a controller's own model is given, shape (M,), in the order of `parameter_layout.MODEL`."""
    return np.concatenate([np.atleast_1d(getattr(control_model, name)) for name in MODEL])


class VehicleState(NamedTuple):
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


def allocate_vehicle_state(lanes: int, kind: type[np.floating[Any]]) -> VehicleState:
    """Raw memory, of one kind of float; what a lane without a flight computes with is 1."""
    sizes = (17, 17, 3, 4, 4, 4, 1, VEHICLE_SIZE, AUTOPILOT_SIZE, DISTURBANCE_SIZE, 1)
    memory = VehicleState(*(aligned_zeros((size, lanes), kind) for size in sizes))
    for array in (memory.state[3], memory.vehicle, memory.autopilot):
        array.fill(1)
    return memory


@njit(**COMPILE)
def fly_period(vehicle_state: VehicleState, steps: int) -> None:
    """Fly one control period of so many steps; at its beginning the older command still acts."""
    for i in range(3):
        vehicle_state.before[i] = vehicle_state.state[i]
    for s in range(steps):
        is_older = vehicle_state.older_steps[0] > s
        for a in range(4):
            vehicle_state.command[a] = select(is_older, vehicle_state.older[a], vehicle_state.acting[a])
        step_plant(
            vehicle_state.state,
            vehicle_state.command,
            vehicle_state.vehicle,
            vehicle_state.autopilot,
            vehicle_state.disturbance,
            vehicle_state.step,
            vehicle_state.moved,
        )
        for i in range(17):
            vehicle_state.state[i] = vehicle_state.moved[i]
