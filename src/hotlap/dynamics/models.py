"""The equations of motion, once, as CasADi expressions with symbolic physical parameters.

The planner takes `point_mass`, `planning_model` and `airframe` as they are; `flight.compile` turns `node_map`, `linearised_node_map` and
`plant_step` into the flight core's code. Change the model here and nowhere else; another model for the controller needs no
linearisation of its own (`linearisation`, `flight.generic_mpc`).
Vectors are CasADi columns; conventions are those of `quadrotor.py`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca

from hotlap.dynamics.parameter_layout import AUTOPILOT, DISTURBANCE, MODEL, VEHICLE, airframe_layout, planning_parameters

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


def planning_model(rotors: int = 4) -> ca.Function:
    """(state p v q w, rotor thrusts, parameters) -> state': rigid body with linear drag, as in rpg_time_optimal."""
    state, thrusts, parameters = ca.SX.sym("x", 13), ca.SX.sym("u", rotors), ca.SX.sym("c", planning_parameters(rotors))
    velocity, attitude, rates = state[3:6], state[6:10], state[10:]
    mass, gravity, drag, inertia = parameters[0], parameters[1], parameters[2], parameters[3:6]
    torques = ca.reshape(parameters[6:], rotors, 3).T @ thrusts
    acceleration = thrust_axis(attitude) * (ca.sum1(thrusts) / mass) - ca.vertcat(0, 0, gravity) - drag * velocity
    derivative = ca.vertcat(velocity, acceleration, quaternion_rate(attitude, rates), angular_acceleration(rates, torques, inertia))
    return ca.Function("planning_model", [state, thrusts, parameters], [derivative])


def point_mass_in_air(rotors: int = 4) -> ca.Function:
    """(state p v, thrust vector per mass, `airframe_layout`) -> state': with the drags of a vehicle whose body z is along its thrust.

    In the plane of the rotors, where a point mass has no heading, drag is the mean of both axes.
    """
    state, thrust, parameters = ca.SX.sym("x", 6), ca.SX.sym("u", 3), ca.SX.sym("c", sum(airframe_layout(rotors).values()))
    vehicle, velocity = split(parameters, airframe_layout(rotors)), state[3:]
    size = ca.sqrt(ca.dot(thrust, thrust) + LEAST_PUSH**2)
    axis = thrust / size
    along = ca.dot(velocity, axis)
    across = velocity - along * axis
    roots = math.sqrt(rotors) * ca.sqrt(vehicle["mass"] * size)  # of the rotor thrusts, summed
    level = (vehicle["drag"][0] + vehicle["drag"][1]) / 2 + roots * vehicle["rotor_drag"] / vehicle["mass"]
    broad = (vehicle["body_drag"][0] + vehicle["body_drag"][1]) / 2 * ca.sqrt(ca.dot(across, across) + LEAST_SPEED**2)
    face = vehicle["body_drag"][2] * ca.sqrt(along**2 + LEAST_SPEED**2)
    drag = (level + broad / vehicle["mass"]) * across + (vehicle["drag"][2] + face / vehicle["mass"]) * along * axis
    return ca.Function("point_mass_in_air", [state, thrust, parameters], [ca.vertcat(velocity, thrust - vehicle["gravity"] * E3 - drag)])


E3 = ca.DM([0, 0, 1])
LEAST_PUSH = 0.1  # m/s^2, so that a thrust has a direction in free fall
LEAST_SPEED = 0.1  # m/s, so that a speed can be differentiated at rest
LEAST_ROTOR = 1e-3  # share of the weight that a rotor carries in hover, so that the square root of its thrust can be differentiated


def airframe(rotors: int = 4) -> ca.Function:
    """(state p v q w, rotor thrusts, `airframe_layout`) -> state': rigid body with all drags of the vehicle, as the plant flies it."""
    state, thrusts, parameters = ca.SX.sym("x", 13), ca.SX.sym("u", rotors), ca.SX.sym("c", sum(airframe_layout(rotors).values()))
    vehicle = split(parameters, airframe_layout(rotors))
    velocity, attitude, rates = state[3:6], state[6:10], state[10:]
    rotation, least = rotation_matrix(attitude), LEAST_ROTOR * vehicle["mass"] * vehicle["gravity"] / rotors
    speeds = ca.sum1(ca.sqrt(ca.sqrt(thrusts**2 + least**2)))
    drag = rotation @ drag_of(rotation.T @ velocity, speeds, vehicle)
    acceleration = thrust_axis(attitude) * (ca.sum1(thrusts) / vehicle["mass"]) - vehicle["gravity"] * E3 - drag
    turn = angular_acceleration(rates, ca.reshape(vehicle["torques"], rotors, 3).T @ thrusts, vehicle["inertia"])
    derivative = ca.vertcat(velocity, acceleration, quaternion_rate(attitude, rates), turn)
    return ca.Function("airframe", [state, thrusts, parameters], [derivative])


SERIES_ORDER = 3  # of the entire functions below: good to 1e-6 at a rotation of 1 rad a node, to 3e-4 at 2 rad


def power_series(s: Expression, first: float, ratio: Callable[[int], float], order: int = SERIES_ORDER) -> Expression:
    """first (1 - s / ratio(0) (1 - s / ratio(1) (...))), by Horner's rule."""
    total: Expression = 1.0
    for k in reversed(range(order)):
        total = 1 - (s / ratio(k)) * total
    return first * total


def rotation_quaternion(phi: Expression) -> Expression:
    """exp(phi / 2), the quaternion of a rotation vector."""
    quarter = ca.dot(phi, phi) / 4
    cosine = power_series(quarter, 1.0, lambda k: (2 * k + 1) * (2 * k + 2))
    sine = power_series(quarter, 0.5, lambda k: (2 * k + 2) * (2 * k + 3))  # sin(|phi| / 2) / |phi|
    return ca.vertcat(cosine, sine * phi)


def rotation_integral(phi: Expression, vector: Expression, times: int) -> Expression:
    """Integral of exp([phi s]x) vector over s from 0 to 1, taken once or twice.

    I + [phi]x / (n + 1)! .. summed in closed form: vector / n! + c_n phi x vector + c_{n+1} phi x (phi x vector).
    """
    s = ca.dot(phi, phi)
    factorial = {1: 1.0, 2: 2.0, 3: 6.0, 4: 24.0}
    linear = power_series(s, 1 / factorial[times + 1], lambda k: (2 * k + times + 2) * (2 * k + times + 3))
    square = power_series(s, 1 / factorial[times + 2], lambda k: (2 * k + times + 3) * (2 * k + times + 4))
    across = ca.cross(phi, vector)
    return vector / factorial[times] + linear * across + square * ca.cross(phi, across)


def right_jacobian(phi: Expression) -> Expression:
    """Jr(phi): exp(phi + d) = exp(phi) exp(Jr d), to first order in d; shape (3, 3)."""
    s, k = ca.dot(phi, phi), ca.skew(phi)
    linear = power_series(s, 1 / 2, lambda k: (2 * k + 3) * (2 * k + 4))
    square = power_series(s, 1 / 6, lambda k: (2 * k + 4) * (2 * k + 5))
    return ca.DM.eye(3) - linear * k + square * (k @ k)


def tangent(q: Expression, r: Expression) -> Expression:
    """Attitude error from q to r as a 3-vector (body), 2 vec(conj(q) o r)."""
    return 2 * quaternion_product(ca.vertcat(q[0], -q[1:]), r)[1:]


def _node(x: Expression, u: Expression, h: Expression, gravity: Expression) -> Expression:
    """The state after a node of the horizon: thrust and body rates held for h, integrated exactly."""
    velocity, attitude, phi, impulse = x[7:], x[3:7], h * u[1:], h * u[0]
    rotation = rotation_matrix(attitude)
    position = x[:3] + h * velocity + h * impulse * (rotation @ rotation_integral(phi, E3, 2)) - gravity * h**2 / 2 * E3
    after = velocity + impulse * (rotation @ rotation_integral(phi, E3, 1)) - gravity * h * E3
    return ca.vertcat(position, quaternion_product(attitude, rotation_quaternion(phi)), after)


def node_map() -> ca.Function:
    """The controller's model, (state p q v, thrust per mass and rates, duration, gravity) -> state after it (Eq. 3 of the paper).

    It has no drag, as the paper's.
    """
    x, u, h, gravity = ca.SX.sym("x", 10), ca.SX.sym("u", 4), ca.SX.sym("h"), ca.SX.sym("g")
    return ca.Function("node_map", [x, u, h, gravity], [_node(x, u, h, gravity)], {"cse": True})


LEAST_THRUST = 1e-3  # m/s^2, so that the root below can be differentiated


def drag_node_map() -> ca.Function:
    """The controller's model with the drags of the vehicle, (state p q v, thrust per mass and rates, duration, `MODEL`) -> state after it.

    Half of the drag's impulse acts before the node and half behind it (Strang, SIAM J. Numer. Anal. 5, 1968). All rotors are taken to
    give the same thrust.
    """
    x, u, h, constants = ca.SX.sym("x", 10), ca.SX.sym("u", 4), ca.SX.sym("h"), ca.SX.sym("c", sum(MODEL.values()))
    vehicle = split(constants, MODEL)
    speeds = _rotor_speeds(u[0], vehicle)

    def push(state: Expression) -> Expression:
        """The state after half of the drag."""
        rotation = rotation_matrix(state[3:7])
        air = rotation.T @ state[7:]
        middle = air - h / 4 * drag_of(air, speeds, vehicle)
        return ca.vertcat(state[:7], state[7:] - h / 2 * (rotation @ drag_of(middle, speeds, vehicle)))

    return ca.Function("drag_node_map", [x, u, h, constants], [push(_node(push(x), u, h, vehicle["gravity"]))], {"cse": True})


def air_drag() -> ca.Function:
    """(state p q v, thrust per mass and rates, `MODEL`) -> deceleration by all drags, shape (3,) [m/s^2] (world).

    All rotors are taken to give the same thrust.
    """
    x, u, constants = ca.SX.sym("x", 10), ca.SX.sym("u", 4), ca.SX.sym("c", sum(MODEL.values()))
    vehicle, rotation = split(constants, MODEL), rotation_matrix(x[3:7])
    drag = rotation @ drag_of(rotation.T @ x[7:], _rotor_speeds(u[0], vehicle), vehicle)
    return ca.Function("air_drag", [x, u, constants], [drag], {"cse": True})


def _rotor_speeds(thrust: Expression, vehicle: dict) -> Expression:
    """Sum of the square roots of the rotor thrusts [N^0.5] that share a thrust per mass evenly, 4 sqrt(m T / 4)."""
    return 2 * ca.sqrt(vehicle["mass"] * ca.fmax(thrust, LEAST_THRUST))


def node_jacobian(x: Expression, u: Expression, h: Expression) -> Expression:
    """The Jacobian of `node_map` in tangent coordinates (p, theta, v), of which only what is neither 0 nor 1 is kept.

        theta+ = Ct [theta, w],   v+ = v + Cv [theta, T, w],   p+ = p + h / 2 (v + v+)

    Attitudes are perturbed as q o [1, theta / 2]. The third line is an approximation of third order in h.

    Returns:
        Ct's columns of theta, then those of w, then Cv, each row by row, shape (39,).
    """
    phi, impulse, rotation = h * u[1:], h * u[0], rotation_matrix(x[3:7])
    thrust = rotation_integral(phi, E3, 1)
    symbol = ca.SX.sym("phi", 3)
    bend = ca.substitute(ca.jacobian(rotation_integral(symbol, E3, 1), symbol), symbol, phi)
    turn = rotation_matrix(rotation_quaternion(phi)).T
    rates = h * right_jacobian(phi)
    thrusts = ca.horzcat(-impulse * (rotation @ ca.skew(thrust)), h * (rotation @ thrust), h * impulse * (rotation @ bend))
    return ca.vertcat(ca.vec(turn.T), ca.vec(rates.T), ca.vec(thrusts.T))


def linearised_node_map() -> ca.Function:
    """The model of a node, linearised around the plan, and the defect: by how much the plan's next state differs from the model's.

    (state, input, next state of the plan, deviation at this node, duration, bounds of the input, gravity)
    -> input within its bounds, deviation at the next node, Jacobian as in `node_jacobian`.
    """
    x, u, following = ca.SX.sym("x", 10), ca.SX.sym("u", 4), ca.SX.sym("x+", 10)
    deviation, h, gravity = ca.SX.sym("dx", 9), ca.SX.sym("h"), ca.SX.sym("g")
    low, high = ca.SX.sym("low", 4), ca.SX.sym("high", 4)
    bounded = ca.fmin(ca.fmax(u, low), high)
    after, jacobian = _node(x, u, h, gravity), node_jacobian(x, u, h)
    turn, rates = ca.reshape(jacobian[:9], 3, 3).T, ca.reshape(jacobian[9:18], 3, 3).T
    change = ca.reshape(jacobian[18:], 7, 3).T @ ca.vertcat(deviation[3:6], bounded - u)
    reached = ca.vertcat(
        after[:3] - following[:3] + deviation[:3] + h * (deviation[6:] + change / 2),
        tangent(following[3:7], after[3:7]) + turn @ deviation[3:6] + rates @ (bounded - u)[1:],
        after[7:] - following[7:] + deviation[6:] + change,
    )
    inputs = [x, u, following, deviation, h, low, high, gravity]
    return ca.Function("linearised_node_map", inputs, [bounded, reached, jacobian], {"cse": True})


def split(symbol: Expression, sizes: Mapping[str, int]) -> dict[str, Expression]:
    """Named parts of a column."""
    ends = [sum(list(sizes.values())[:k]) for k in range(len(sizes) + 1)]
    return dict(zip(sizes, ca.vertsplit(symbol, ends), strict=True))


def _rotor_command(rates: Expression, speeds: Expression, command: Expression, vehicle: dict, autopilot: dict) -> Expression:
    """Rate loop and mixer: thrusts that the rotors are asked for, within their limits.

    torque = J k (w_cmd - w) + w x J w - damping (present torque - w x J w)
    """
    inertia = autopilot["inertia"]
    gyroscopic = ca.cross(rates, inertia * rates)
    present = ca.reshape(vehicle["torques"], 4, 3).T @ speeds**2
    wanted = inertia * vehicle["rate_gain"] * (command[1:] - rates) + gyroscopic
    torque = wanted - vehicle["torque_damping"] * (present - gyroscopic)
    thrusts = ca.reshape(autopilot["mixer"], 4, 4).T @ ca.vertcat(autopilot["mass"] * command[0], torque)
    return ca.fmin(ca.fmax(thrusts, vehicle["rotor_thrust"][0]), vehicle["rotor_thrust"][1])


def drag_of(air: Expression, speeds: Expression, vehicle: dict) -> Expression:
    """Deceleration by all drags (body), of a velocity through the air (body); `speeds` sums the square roots of the rotor thrusts."""
    along = ca.vertcat(air[:2] * speeds, 0)  # RotorS: in the rotor plane, with the rotors' speed
    return (vehicle["rotor_drag"] * along + vehicle["body_drag"] * air * ca.fabs(air)) / vehicle["mass"] + vehicle["drag"] * air


def _body(state: Expression, speeds: Expression, vehicle: dict, disturbance: dict) -> Expression:
    """Rigid body with the rotors' thrust, drags and wind: (p q v w)'."""
    attitude, velocity, rates = state[3:7], state[7:10], state[10:13]
    rotation, thrusts = rotation_matrix(attitude), speeds**2
    air = rotation.T @ velocity
    thrust = ca.sum1(thrusts) * disturbance["thrust_factor"] / vehicle["mass"] * E3
    acceleration = rotation @ (thrust - drag_of(air, ca.sum1(speeds), vehicle)) - vehicle["gravity"] * E3 + disturbance["wind"]
    torque = ca.reshape(vehicle["torques"], 4, 3).T @ thrusts
    turn = angular_acceleration(rates, torque, vehicle["inertia"])
    return ca.vertcat(velocity, quaternion_rate(attitude, rates), acceleration, turn)


def plant_step() -> ca.Function:
    """One step of the vehicle: (p q v w s, command, vehicle, autopilot, disturbance, step) -> state after it.

    s are the square roots of the rotor thrusts [N^0.5], which follow their command as rotor speeds do: exactly, with separate
    time constants up and down. The body is integrated by the midpoint rule. Command: thrust per mass and body rates.
    """
    state, command, step = ca.SX.sym("x", 17), ca.SX.sym("u", 4), ca.SX.sym("h")
    vehicle, autopilot = ca.SX.sym("v", sum(VEHICLE.values())), ca.SX.sym("a", sum(AUTOPILOT.values()))
    disturbance = ca.SX.sym("d", sum(DISTURBANCE.values()))
    actual, assumed, chance = split(vehicle, VEHICLE), split(autopilot, AUTOPILOT), split(disturbance, DISTURBANCE)
    body, speeds = state[:13], state[13:]
    gap = ca.sqrt(_rotor_command(body[10:], speeds, command, actual, assumed)) - speeds
    up, down = actual["motor_shares"][0], actual["motor_shares"][1]
    speeds = speeds + up * ca.fmax(gap, 0) + down * ca.fmin(gap, 0)
    middle = body + step / 2 * _body(body, speeds, actual, chance)
    after = body + step * _body(middle, speeds, actual, chance)
    attitude = after[3:7] / ca.norm_2(after[3:7])
    inputs = [state, command, vehicle, autopilot, disturbance, step]
    return ca.Function("plant_step", inputs, [ca.vertcat(after[:3], attitude, after[7:], speeds)], {"cse": True})
