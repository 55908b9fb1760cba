"""The layout of the vectors that the functions of `dynamics` take: named parts, in order, with how many numbers each has."""

from __future__ import annotations

from collections.abc import Mapping

PLANNING_PARAMETERS = 18  # mass, gravity, isotropic drag, inertia (3), torque matrix (3 x 4, row by row)
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
"""Parameters of the vehicle that a plan with all of its drags uses: those of `Quadrotor`; torque matrix row by row."""

AUTOPILOT: Mapping[str, int] = {"mass": 1, "inertia": 3, "mixer": 16}
"""The vehicle as the rate loop knows it; the mixer, row by row, turns (collective thrust, torques) into rotor thrusts."""

MODEL: Mapping[str, int] = {"gravity": 1, "mass": 1, "drag": 3, "rotor_drag": 1, "body_drag": 3}
"""Parameters of the vehicle that a controller's model may use, as in `Quadrotor`."""

DISTURBANCE: Mapping[str, int] = {"thrust_factor": 1, "wind": 3}
"""What differs from flight to flight: a factor of the thrust, and an acceleration [m/s^2] (world)."""


def place_of(name: str, layout: Mapping[str, int]) -> int:
    """Index of the first number of a named part of a vector."""
    names = list(layout)
    return sum(layout[before] for before in names[: names.index(name)])
