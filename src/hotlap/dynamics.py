"""The equations of motion, once, as CasADi expressions with symbolic physical parameters.

The planner takes `point_mass` and `planning_model` as they are; `flight.compile` turns `node_map` (with its
Jacobian), `prediction` and `plant` into the flight core's code. Change the model here and nowhere else.
Vectors are CasADi columns; conventions are those of `quadrotor.py`.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

Expression = Any  # casadi.SX; CasADi ships no types


def quaternion_product(a: Expression, b: Expression) -> Expression:
    """a o b, Hamilton's product, (w, x, y, z)."""
    w = a[0] * b[0] - ca.dot(a[1:], b[1:])
    return ca.vertcat(w, a[0] * b[1:] + b[0] * a[1:] + ca.cross(a[1:], b[1:]))


def rotation_matrix(q: Expression) -> Expression:
    """R(q), body to world, of a unit quaternion."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    return ca.vertcat(
        ca.horzcat(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        ca.horzcat(2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        ca.horzcat(2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def thrust_axis(q: Expression) -> Expression:
    """Body z in the world, R(q) e3; of length |q|^2, so that a planner cannot gain by inflating q."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    return ca.vertcat(2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z)


def quaternion_rate(q: Expression, rates: Expression) -> Expression:
    """q' = q o (0, w) / 2."""
    return 0.5 * quaternion_product(q, ca.vertcat(0, rates))


def angular_acceleration(rates: Expression, torque: Expression, inertia: Expression) -> Expression:
    """w' = J^-1 (torque - w x J w)."""
    return (torque - ca.cross(rates, inertia * rates)) / inertia


def point_mass() -> ca.Function:
    """(state p v, thrust vector per mass, [gravity, drag]) -> state'."""
    state, thrust, parameters = ca.SX.sym("x", 6), ca.SX.sym("u", 3), ca.SX.sym("c", 2)
    velocity = state[3:]
    acceleration = thrust - ca.vertcat(0, 0, parameters[0]) - parameters[1] * velocity
    return ca.Function("point_mass", [state, thrust, parameters], [ca.vertcat(velocity, acceleration)])


PLANNING_PARAMETERS = 18  # mass, gravity, isotropic drag, inertia (3), torque matrix (3 x 4, row by row)


def planning_model() -> ca.Function:
    """(state p v q w, rotor thrusts, parameters) -> state': rigid body with linear drag, as in rpg_time_optimal."""
    state, thrusts, parameters = ca.SX.sym("x", 13), ca.SX.sym("u", 4), ca.SX.sym("c", PLANNING_PARAMETERS)
    velocity, attitude, rates = state[3:6], state[6:10], state[10:]
    mass, gravity, drag, inertia = parameters[0], parameters[1], parameters[2], parameters[3:6]
    torques = ca.reshape(parameters[6:], 4, 3).T @ thrusts
    acceleration = thrust_axis(attitude) * (ca.sum1(thrusts) / mass) - ca.vertcat(0, 0, gravity) - drag * velocity
    derivative = ca.vertcat(velocity, acceleration, quaternion_rate(attitude, rates), angular_acceleration(rates, torques, inertia))
    return ca.Function("planning_model", [state, thrusts, parameters], [derivative])
