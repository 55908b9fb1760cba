"""The layout of the vectors that the functions of `dynamics` take: named parts, in order, with how many numbers each has."""

from __future__ import annotations

from collections.abc import Mapping

TANGENT, TANGENT_COLUMNS = 9, 13  # deviations p, theta, v of a state; with those of an input
NODE_JACOBIAN = 39  # numbers that linearise a node of the controller's horizon

VEHICLE: Mapping[str, int] = {
    "mass": 1,
    "inertia": 3,
    "torques": 12,
    "rotor_thrust": 2,
    "motor_shares": 2,
    "drag": 3,
    "rotor_drag": 1,
    "body_drag": 3,
    "gravity": 1,
    "rate_gain": 3,
    "torque_damping": 1,
}
"""Physical parameters of the plant: those of `Quadrotor`; torque matrix row by row; motor shares are 1 - exp(-step / motor_time), up
and down."""

AIRFRAME: Mapping[str, int] = {"mass": 1, "gravity": 1, "inertia": 3, "torques": 12, "drag": 3, "rotor_drag": 1, "body_drag": 3}
"""Parameters of the vehicle that a plan with all of its drags uses, for four rotors: those of `Quadrotor`; torque matrix row by row."""

AUTOPILOT: Mapping[str, int] = {"mass": 1, "inertia": 3, "mixer": 16}
"""The vehicle as the rate loop knows it; the mixer, row by row, turns (collective thrust, torques) into rotor thrusts."""

MODEL: Mapping[str, int] = {"gravity": 1, "mass": 1, "drag": 3, "rotor_drag": 1, "body_drag": 3}
"""Parameters of the vehicle that a controller's model may use, as in `Quadrotor`."""

DISTURBANCE: Mapping[str, int] = {"thrust_factor": 1, "wind": 3}
"""What differs from flight to flight: a factor of the thrust, and an acceleration [m/s^2] (world)."""


def planning_parameters(rotors: int) -> int:
    """How many parameters `planning_model` takes: mass, gravity, isotropic drag, inertia (3), torque matrix (3 x rotors, row by row)."""
    return 6 + 3 * rotors


def airframe_layout(rotors: int) -> Mapping[str, int]:
    """`AIRFRAME` for so many rotors."""
    return {name: 3 * rotors if name == "torques" else size for name, size in AIRFRAME.items()}


def detailed_vehicle(rotors: int) -> Mapping[str, int]:
    """Parameters of a detailed plant: those of `VEHICLE` for so many rotors, and what follows.

    With a PID rate loop, rate_gain is a factor of its signals [-]. thrust_lag is 1 where the thrust of the rotors follows its command,
    0 where their speed does; inflow as in `Quadrotor`; rotor momentum is that of each rotor over the square root of its thrust
    [N m s / N^0.5], with the sign of its yaw torque.
    """
    sizes = {name: 3 * rotors if name == "torques" else size for name, size in VEHICLE.items()}
    return {**sizes, "thrust_lag": 1, "inflow": 1, "rotor_momentum": rotors}


def detailed_autopilot(rotors: int) -> Mapping[str, int]:
    """The vehicle as the rate loop of a detailed plant knows it; mixer (rotors x 4) and mix (rotors x 3) row by row.

    torque_limits [N m] hold for the mixer `betaflight`. largest is the thrust [N] of a rotor at the signal 1; mix, p, i, d, limit,
    integral_limit and idle are those of a `RateLoop`; d_share is by how much a step moves the filter of the derivative; on_speed is 1 where
    signals are shares of full speed.
    """
    return {
        "mass": 1, "inertia": 3, "mixer": 4 * rotors, "torque_limits": 3, "largest": 1, "mix": 3 * rotors,
        "p": 3, "i": 3, "d": 3, "d_share": 1, "integral_limit": 1, "limit": 3, "idle": 1, "on_speed": 1,
    }  # fmt: skip


LOOP_STATE: Mapping[str, int] = {"integral": 3, "measured": 3, "slope": 3}
"""What a PID rate loop remembers: integral parts [-], rates measured in the step before [rad/s], and their filtered derivatives."""


def place_of(name: str, layout: Mapping[str, int]) -> int:
    """Index of the first number of a named part of a vector."""
    names = list(layout)
    return sum(layout[before] for before in names[: names.index(name)])
