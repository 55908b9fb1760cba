"""The detailed plant: a step of vehicles of which more is said than that of `models.plant_step`, as CasADi expressions.

Any number of rotors, mixers that share out what the rotors cannot give, rate loops with integral and derivative parts, motors whose thrust
follows its command, angular momentum of the rotors, and thrust that axial flow takes.
"""

from __future__ import annotations

import casadi as ca

from hotlap.dynamics.mixers import LEAST_THROTTLE, Mixer
from hotlap.dynamics.models import E3, Expression, angular_acceleration, drag_of, quaternion_rate, rotation_matrix, split
from hotlap.dynamics.parameter_layout import DISTURBANCE, LOOP_STATE, detailed_autopilot, detailed_vehicle


def _rows(symbol: Expression, columns: int) -> Expression:
    """A matrix that is stored row by row."""
    return ca.reshape(symbol, columns, symbol.numel() // columns).T


def _between(low: Expression, value: Expression, high: Expression) -> Expression:
    """A value within its limits."""
    return ca.fmin(ca.fmax(value, low), high)


def _extremes(values: Expression, first: Expression) -> tuple[Expression, Expression]:
    """The least and the largest of some numbers and `first`."""
    least = largest = first
    for value in ca.vertsplit(values):
        least, largest = ca.fmin(least, value), ca.fmax(largest, value)
    return least, largest


def mix(mixer: Mixer, throttle: Expression, turn: Expression, low: Expression, high: Expression, share: Expression) -> Expression:
    """What each rotor is asked for, within its limits.

    Args:
        mixer: what becomes of what is beyond them.
        throttle: shape (n,), what the rotors would give without torques.
        turn: shape (n,), what they give more to make torques.
        low: least that a rotor gives.
        high: most that it gives.
        share: of the largest thrust that is asked for in all [-].
    """
    if mixer is Mixer.CLIP:
        return _between(low, throttle + turn, high)
    if mixer is Mixer.SCALE:
        asked = throttle + turn
        lifted = asked + ca.fmax(low - _extremes(asked, asked[0])[0], 0)
        scaled = lifted * ca.fmin(high / ca.fmax(_extremes(lifted, lifted[0])[1], high), 1)
        return _between(low, ca.if_else(share < LEAST_THROTTLE, throttle, scaled), high)
    least, largest = _extremes(turn, ca.SX(0))
    fitting = turn / ca.fmax((largest - least) / (high - low), 1)
    asked = throttle + fitting
    below, above = _extremes(asked, asked[0])
    return _between(low, asked + ca.fmax(low - below, 0) - ca.fmax(above - high, 0), high)


def _asked_in_torques(
    mixer: Mixer, rates: Expression, speeds: Expression, command: Expression, vehicle: dict, autopilot: dict
) -> Expression:
    """Thrusts that the proportional rate loop of `models.plant_step` and a mixer ask for."""
    inertia, to_rotors = autopilot["inertia"], _rows(autopilot["mixer"], 4)
    gyroscopic = ca.cross(rates, inertia * rates)
    present = _rows(vehicle["torques"], speeds.numel()) @ speeds**2
    wanted = inertia * vehicle["rate_gain"] * (command[1:] - rates) + gyroscopic
    torque = wanted - vehicle["torque_damping"] * (present - gyroscopic)
    if mixer is Mixer.BETAFLIGHT:
        torque = _between(-autopilot["torque_limits"], torque, autopilot["torque_limits"])
    least, largest = vehicle["rotor_thrust"][0], vehicle["rotor_thrust"][1]
    push = autopilot["mass"] * command[0]
    share = push / (speeds.numel() * autopilot["largest"])
    return mix(mixer, to_rotors[:, 0] * push, to_rotors[:, 1:] @ torque, least, largest, share)


def _asked_in_signals(
    mixer: Mixer, rates: Expression, memory: dict, command: Expression, vehicle: dict, autopilot: dict, step: Expression
) -> tuple[Expression, Expression]:
    """Thrusts that a PID rate loop in signals and a mixer ask for, and what the loop remembers; (n,) and `LOOP_STATE`."""
    rotors = autopilot["mix"].numel() // 3
    error = command[1:] - rates
    integral = _between(-autopilot["integral_limit"], memory["integral"] + autopilot["i"] * error * step, autopilot["integral_limit"])
    slope = memory["slope"] + autopilot["d_share"] * ((rates - memory["measured"]) / step - memory["slope"])
    answer = vehicle["rate_gain"] * (autopilot["p"] * error + integral - autopilot["d"] * slope)
    turn = _between(-autopilot["limit"], answer, autopilot["limit"])
    share, idle = _between(0, autopilot["mass"] * command[0] / (rotors * autopilot["largest"]), 1), autopilot["idle"]
    output = share + autopilot["on_speed"] * (ca.sqrt(share) - share)
    throttle = ca.fmax((output - idle) / (1 - idle), 0)
    signals = mix(mixer, ca.repmat(throttle, rotors), _rows(autopilot["mix"], 3) @ turn, ca.SX(0), ca.SX(1), share)
    outputs = idle + (1 - idle) * signals
    shares = outputs + autopilot["on_speed"] * (outputs**2 - outputs)
    thrusts = ca.fmax(vehicle["rotor_thrust"][1] * shares, vehicle["rotor_thrust"][0])
    return thrusts, ca.vertcat(integral, rates, slope)


def _body(state: Expression, speeds: Expression, spin_up: Expression, vehicle: dict, disturbance: dict) -> Expression:
    """Rigid body with the rotors' thrust and momentum, drags and wind: (p q v w)'; `spin_up` are the derivatives of the speeds."""
    attitude, velocity, rates = state[3:7], state[7:10], state[10:13]
    rotation, torques, momentum = rotation_matrix(attitude), _rows(vehicle["torques"], speeds.numel()), vehicle["rotor_momentum"]
    air = rotation.T @ velocity
    axial = air[2] + torques[0, :].T * rates[0] + torques[1, :].T * rates[1]  # at each rotor: levers are roll and pitch torques per thrust
    thrusts = speeds**2 - vehicle["inflow"] * speeds * axial
    push = ca.sum1(thrusts) * disturbance["thrust_factor"] / vehicle["mass"] * E3
    acceleration = rotation @ (push - drag_of(air, ca.sum1(speeds), vehicle)) - vehicle["gravity"] * E3 + disturbance["wind"]
    carried = ca.dot(momentum, speeds)  # of all rotors, about -z of the body
    gyroscopic = ca.vertcat(carried * rates[1], -carried * rates[0], ca.dot(momentum, spin_up))
    torque = ca.vertcat(torques[:2, :] @ thrusts, torques[2, :] @ speeds**2) + gyroscopic
    turn = angular_acceleration(rates, torque, vehicle["inertia"])
    return ca.vertcat(velocity, quaternion_rate(attitude, rates), acceleration, turn)


def detailed_plant_step(rotors: int, mixer: Mixer, *, pid: bool) -> ca.Function:
    """One step of a vehicle: (p q v w s memory, command, measured rates, vehicle, autopilot, disturbance, step) -> state after it.

    s are the square roots of the rotor thrusts at rest [N^0.5]. The body is integrated by the midpoint rule.

    Args:
        rotors: how many.
        mixer: of the flight controller.
        pid: whether the rate loop is a PID in signals, which remembers `LOOP_STATE`; else it is that of `models.plant_step`.
    """
    layouts, remembered = (detailed_vehicle(rotors), detailed_autopilot(rotors), DISTURBANCE), sum(LOOP_STATE.values()) if pid else 0
    state, command, measured, step = (ca.SX.sym(name, size) for name, size in zip("xuyh", (13 + rotors + remembered, 4, 3, 1), strict=True))
    numbers = [ca.SX.sym(name, sum(layout.values())) for name, layout in zip("vad", layouts, strict=True)]
    actual, assumed, chance = (split(*pair) for pair in zip(numbers, layouts, strict=True))
    body, before, memory = state[:13], state[13 : 13 + rotors], state[13 + rotors :]
    if pid:
        asked, memory = _asked_in_signals(mixer, measured, split(memory, LOOP_STATE), command, actual, assumed, step)
    else:
        asked = _asked_in_torques(mixer, measured, before, command, actual, assumed)
    after, speeds = _after(body, before, asked, actual, chance, step)
    return ca.Function(
        "detailed_plant_step", [state, command, measured, *numbers, step], [ca.vertcat(after, speeds, memory)], {"cse": True}
    )


def detailed_rotor_step(rotors: int) -> ca.Function:
    """One step without the rate loop: (p q v w s, thrusts that the rotors are asked for, vehicle, disturbance, step) -> state after it.

    State, rotors and body are those of `detailed_plant_step`.

    Args:
        rotors: how many.
    """
    state, asked, step = ca.SX.sym("x", 13 + rotors), ca.SX.sym("f", rotors), ca.SX.sym("h")
    layouts = detailed_vehicle(rotors), DISTURBANCE
    vehicle, disturbance = (ca.SX.sym(name, sum(layout.values())) for name, layout in zip("vd", layouts, strict=True))
    after = _after(state[:13], state[13:], asked, split(vehicle, layouts[0]), split(disturbance, DISTURBANCE), step)
    return ca.Function("detailed_rotor_step", [state, asked, vehicle, disturbance, step], [ca.vertcat(*after)], {"cse": True})


def _after(
    body: Expression, before: Expression, asked: Expression, vehicle: dict, disturbance: dict, step: Expression
) -> tuple[Expression, Expression]:
    """(p q v w) and the square roots of the rotor thrusts after a step in which the rotors follow the thrusts that are asked for."""
    speeds = _moved(before, asked, vehicle)
    spin_up = (speeds - before) / step
    middle = body + step / 2 * _body(body, speeds, spin_up, vehicle, disturbance)
    after = body + step * _body(middle, speeds, spin_up, vehicle, disturbance)
    return ca.vertcat(after[:3], after[3:7] / ca.norm_2(after[3:7]), after[7:]), speeds


def _moved(before: Expression, asked: Expression, vehicle: dict) -> Expression:
    """Square roots of the rotor thrusts after a step in which they, or the thrusts, follow what is asked for."""
    by_thrust = vehicle["thrust_lag"]
    now = before + by_thrust * (before**2 - before)
    goal = ca.sqrt(asked) + by_thrust * (asked - ca.sqrt(asked))
    after = now + vehicle["motor_shares"][0] * ca.fmax(goal - now, 0) + vehicle["motor_shares"][1] * ca.fmin(goal - now, 0)
    return after + by_thrust * (ca.sqrt(ca.fmax(after, 0)) - after)
