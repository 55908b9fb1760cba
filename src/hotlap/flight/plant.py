"""The plant: the vehicle's physical parameters in the order of the equations of motion, and a control period of simulated flight."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.dynamics.parameter_layout import AUTOPILOT, DISTURBANCE, MODEL, VEHICLE, place_of
from hotlap.flight.compile import compiled_dynamics
from hotlap.flight.lanes import select
from hotlap.flight.numbers import COMPILE, aligned_zeros
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import PLANT_STEP
from hotlap.race.rotors import RotorLayout, torque_matrix
from hotlap.race.vehicle_parameters import COLUMNS, check_vehicle_parameters, part_of

Floats = NDArray[np.float64]

step_plant = compiled_dynamics("plant_step")


def vehicle_numbers(vehicle_parameters: Floats, layout: RotorLayout) -> Floats:
    """The vehicle's parameters as `dynamics.plant_step` takes them.

    Args:
        vehicle_parameters: shape (B, P).
        layout: of the rotors.

    Returns:
        Shape (B, V), in the order of `parameter_layout.VEHICLE`.

    Raises:
        HotlapError: a physical parameter is impossible; see `check_vehicle_parameters`.
    """
    check_vehicle_parameters(vehicle_parameters)
    parts = {name: part_of(vehicle_parameters, name) for name in COLUMNS}
    unit_arm, unit_ratio = torque_matrix(layout, 1.0, 0.0).ravel(), torque_matrix(layout, 0.0, 1.0).ravel()
    parts["torques"] = parts["arm"] * unit_arm + parts["torque_ratio"] * unit_ratio
    parts["motor_shares"] = motor_shares(parts["motor_time"], PLANT_STEP)
    return np.hstack([parts[name] for name in VEHICLE])


def motor_shares(motor_time: Floats, step: float) -> Floats:
    """Share of the way to its command that a rotor goes in a step [s], of motor times [s]; a motor time of 0 follows at once."""
    with np.errstate(divide="ignore"):
        return np.asarray(1 - np.exp(-step / motor_time), dtype=np.float64)


def rotor_mixer(control_model: Quadrotor) -> Floats:
    """Rotor thrusts of least size that make a collective thrust and torques, shape (n, 4)."""
    made = np.vstack([np.ones(control_model.rotor_count), control_model.torque_matrix])
    mixer = np.linalg.inv(made) if control_model.rotor_count == 4 else np.linalg.pinv(made)
    return np.asarray(mixer, dtype=np.float64)


def autopilot_numbers(control_model: Quadrotor) -> Floats:
    """The control model's mass, inertia and mixer, shape (A,), in the order of `parameter_layout.AUTOPILOT`: what the rate loop uses."""
    parts = {"mass": [control_model.mass], "inertia": control_model.inertia_vector, "mixer": rotor_mixer(control_model).ravel()}
    return np.concatenate([parts[name] for name in AUTOPILOT])


def model_numbers(control_model: Quadrotor) -> Floats:
    """The control model's parameters, shape (M,), in the order of `parameter_layout.MODEL`: what a controller's model may use."""
    parts = {name: np.atleast_1d(getattr(control_model, name)) for name in MODEL}
    parts["rotor_drag"] = parts["rotor_drag"] * (math.sqrt(control_model.rotor_count) / 2)  # the model has four rotors
    return np.concatenate([parts[name] for name in MODEL])


class VehicleState(NamedTuple):
    """Memory of the simulated vehicle; raw floats (..., lanes), or numbers (...).

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
MASS, THRUST_FACTOR, WIND = place_of("mass", VEHICLE), place_of("thrust_factor", DISTURBANCE), place_of("wind", DISTURBANCE)


def allocate_vehicle_state(lanes: int, kind: type[np.floating[Any]]) -> VehicleState:
    """Raw memory, of one kind of float; a lane without a flight computes with ones, so that it divides by no zero."""
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
