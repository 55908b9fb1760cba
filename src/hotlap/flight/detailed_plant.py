"""The detailed plant in the flight core: its numbers, its memory, and a control period; see `dynamics.detailed_plant`."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.dynamics.mixers import Mixer
from hotlap.dynamics.parameter_layout import LOOP_STATE, detailed_autopilot, detailed_vehicle
from hotlap.flight.compile import compiled, translate
from hotlap.flight.lanes import select
from hotlap.flight.numbers import COMPILE, aligned_zeros
from hotlap.flight.plant import DISTURBANCE_SIZE, motor_shares, rotor_mixer
from hotlap.race.plant_kind import DetailedKind, detailed_kind
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import PLANT_STEP
from hotlap.race.rate_loop import LIMITS, MotorLag, Output, RateLoop
from hotlap.race.rotors import torques_of
from hotlap.race.vehicle_parameters import COLUMNS, check_vehicle_parameters, part_of

Floats = NDArray[np.float64]

NO_LOOP = RateLoop(p=(1.0, 1.0, 1.0))
NO_LIMIT = 1e9  # N m


@cache
def detailed_step(kind: str) -> Callable[..., None]:
    """The compiled step of a kind of detailed plant."""
    mixer, pid, rotors = detailed_kind(kind)
    return compiled(lambda: translate(import_module("hotlap.dynamics.detailed_plant").detailed_plant_step(rotors, mixer, pid=pid)))


def detailed_vehicle_numbers(vehicle_parameters: Floats, quadrotor: Quadrotor, step: float = PLANT_STEP) -> Floats:
    """The vehicle's parameters as a detailed plant takes them.

    Args:
        vehicle_parameters: shape (B, P).
        quadrotor: what is not among the vehicle parameters.
        step: [s] of the plant.

    Returns:
        Shape (B, V), in the order of `parameter_layout.detailed_vehicle`.

    Raises:
        HotlapError: a physical parameter is impossible; see `check_vehicle_parameters`.
    """
    check_vehicle_parameters(vehicle_parameters)
    parts = {name: part_of(vehicle_parameters, name) for name in COLUMNS}
    places, spins = quadrotor.rotor_positions / quadrotor.arm, quadrotor.rotor_spins
    by_arm, by_ratio = torques_of(places, spins, 0.0).ravel(), torques_of(0 * places, spins, 1.0).ravel()
    parts["torques"] = parts["arm"] * by_arm + parts["torque_ratio"] * by_ratio
    if quadrotor.rate_loop is not None:
        parts["rate_gain"] = parts["rate_gain"] / np.array(quadrotor.rate_gain)
    parts["motor_shares"] = motor_shares(parts["motor_time"], step)
    rows = len(vehicle_parameters)
    parts["thrust_lag"] = np.full((rows, 1), float(quadrotor.motor_lag is MotorLag.THRUST))
    parts["inflow"] = np.full((rows, 1), quadrotor.inflow)
    momentum = quadrotor.rotor_inertia * (quadrotor.rotor_speed or 0.0) / math.sqrt(quadrotor.rotor_thrust[1])
    parts["rotor_momentum"] = np.tile(momentum * spins, (rows, 1))
    return np.hstack([parts[name] for name in detailed_vehicle(quadrotor.rotor_count)])


def detailed_autopilot_numbers(control_model: Quadrotor, vehicle: Quadrotor, step: float = PLANT_STEP) -> Floats:
    """What the rate loop uses, shape (A,), in the order of `parameter_layout.detailed_autopilot`.

    Args:
        control_model: whose mass, inertia, rotors and limits it believes in.
        vehicle: whose rate loop and mixer it is.
        step: [s] of the plant.
    """
    loop, to_rotors = vehicle.rate_loop or NO_LOOP, rotor_mixer(control_model)
    least, largest = control_model.rotor_thrust
    limits = np.array(LIMITS) * (largest - least) / np.abs(to_rotors[:, 1:]).max(axis=0)
    parts: dict[str, Any] = {
        "mass": control_model.mass,
        "inertia": control_model.inertia,
        "mixer": to_rotors,
        "torque_limits": limits if vehicle.mixer is Mixer.BETAFLIGHT else np.full(3, NO_LIMIT),
        "largest": largest,
        "mix": control_model.signal_mix,
        "d_share": 1 - math.exp(-2 * math.pi * loop.d_cutoff * step) if loop.d_cutoff > 0 else 1.0,
        "on_speed": float(loop.output is Output.SPEED),
        **{name: getattr(loop, name) for name in ("p", "i", "d", "integral_limit", "limit", "idle")},
    }
    return np.concatenate([np.ravel(parts[name]) for name in detailed_autopilot(vehicle.rotor_count)])


class DetailedState(NamedTuple):
    """Memory of the simulated vehicle; raw floats (..., lanes), or numbers (...). What is not said here is as in `plant.VehicleState`.

    Attributes:
        state, moved: p q v w, square roots of the rotor thrusts, what the rate loop remembers; now, and a step later.
        history: (H, 3) body rates now, a step ago, and so on.
        between: (1,) the measured rates are this share of the way from the last but one to the last of them.
        measured: (3,) rates that the rate loop acts on.
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
    history: Any
    between: Any
    measured: Any


def allocate_detailed_state(
    kind: DetailedKind, rate_delay: float, lanes: int, real: type[np.floating[Any]], step: float = PLANT_STEP
) -> DetailedState:
    """Raw memory, of one kind of float; a lane without a flight computes with ones, so that it divides by no zero.

    Args:
        kind: of plant.
        rate_delay: [s] age of the measured rates.
        lanes: how many.
        real: kind of float.
        step: [s] of the plant.
    """
    whole = math.floor(rate_delay / step + 1e-9)
    size = 13 + kind.rotors + (sum(LOOP_STATE.values()) if kind.pid else 0)
    vehicle, autopilot = (sum(layout(kind.rotors).values()) for layout in (detailed_vehicle, detailed_autopilot))
    of_plain = [(count,) for count in (size, size, 3, 4, 4, 4, 1, vehicle, autopilot, DISTURBANCE_SIZE, 1)]
    shapes = (*of_plain, (whole + 2, 3), (1,), (3,))
    memory = DetailedState(*(aligned_zeros((*shape, lanes), real) for shape in shapes))
    memory.between.fill(max(rate_delay / step - whole, 0.0))
    for array in (memory.state[3], memory.vehicle, memory.autopilot, memory.step):
        array.fill(1)
    return memory


@cache
def detailed_functions(kind: str) -> tuple[Any, Any]:
    """Two compiled functions of a kind of detailed plant, as in `plants.PlantFunctions`."""
    step, rotors = detailed_step(kind), detailed_kind(kind).rotors
    factor = math.sqrt(4 / rotors)

    def settle(vehicle_state: DetailedState, k: int) -> None:
        """All rotors hover, and the rate loop remembers rest."""
        hover = vehicle_state.state[13, k]
        for n in range(13, len(vehicle_state.state)):
            vehicle_state.state[n, k] = factor * hover if n < 13 + rotors else 0.0
        for n in range(len(vehicle_state.history)):
            for i in range(3):
                vehicle_state.history[n, i, k] = vehicle_state.state[10 + i, k]

    def fly_period(vehicle_state: DetailedState, steps: int) -> None:
        """Fly one control period of so many steps; at its beginning the older command still acts."""
        oldest = len(vehicle_state.history) - 1
        for i in range(3):
            vehicle_state.before[i] = vehicle_state.state[i]
        for s in range(steps):
            is_older = vehicle_state.older_steps[0] > s
            for a in range(4):
                vehicle_state.command[a] = select(is_older, vehicle_state.older[a], vehicle_state.acting[a])
            for i in range(3):
                for n in range(oldest, 0, -1):
                    vehicle_state.history[n, i] = vehicle_state.history[n - 1, i]
                vehicle_state.history[0, i] = vehicle_state.state[10 + i]
                later, sooner = vehicle_state.history[oldest - 1, i], vehicle_state.history[oldest, i]
                vehicle_state.measured[i] = later + vehicle_state.between[0] * (sooner - later)
            step(
                vehicle_state.state,
                vehicle_state.command,
                vehicle_state.measured,
                vehicle_state.vehicle,
                vehicle_state.autopilot,
                vehicle_state.disturbance,
                vehicle_state.step,
                vehicle_state.moved,
            )
            for i in range(len(vehicle_state.state)):
                vehicle_state.state[i] = vehicle_state.moved[i]

    return njit(**COMPILE)(settle), njit(**COMPILE)(fly_period)
