"""Flight performance: hover thrust, tilt, steady flight, agility and speed around a track, from the parameters of a quadrotor."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import PlanDynamics, Race

FASTEST = 100.0  # m/s: beyond this nothing is claimed


def hover_share(quadrotor: Quadrotor) -> float:
    """Share of the largest thrust that hovering takes [-]."""
    return 1 / quadrotor.thrust_to_weight


def max_tilt(quadrotor: Quadrotor) -> float:
    """Tilt [rad] at which full thrust just carries the weight."""
    return math.acos(min(hover_share(quadrotor), 1.0))


def roll_acceleration(quadrotor: Quadrotor) -> float:
    """Largest angular acceleration about body x [rad/s^2]: the rotors of one side full, those of the other at their least."""
    low, high = quadrotor.rotor_thrust
    return float(np.abs(quadrotor.torque_matrix[0]).sum()) * (high - low) / 2 / quadrotor.inertia[0]


def rate_damping(quadrotor: Quadrotor) -> float:
    """Damping ratio of the roll rate loop behind motors and dead time [-]: k / (s (tau s + 1)) closed has zeta = 1 / (2 sqrt(k tau))."""
    lag = float(quadrotor.hover_rate_gain[0]) * (max(quadrotor.motor_time) + quadrotor.rate_delay)
    return 1 / (2 * math.sqrt(lag)) if lag > 0 else math.inf


def command_lag(quadrotor: Quadrotor) -> float:
    """How long a body rate takes to follow its command [s]: of the slower of roll and pitch, 1 / rate_gain and the motors' time."""
    return 1 / float(min(quadrotor.hover_rate_gain[:2])) + max(quadrotor.motor_time)


def steady_thrust(quadrotor: Quadrotor, speed: float, climb: float = 0.0) -> float:
    """Thrust per mass [m/s^2] that steady flight takes, by bisection of the pitch angle.

    With pitch theta and drag D (per mass, body): g sin(theta) = D_x and T = g cos(theta) + D_z.

    Args:
        quadrotor: its three kinds of drag count.
        speed: [m/s] horizontal.
        climb: [m/s] vertical.
    """
    low, high = 0.0, math.pi / 2
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (low, middle) if _pitch_excess(quadrotor, middle, speed, climb) > 0 else (middle, high)
    return _carried(quadrotor, low, speed, climb)


def top_speed(quadrotor: Quadrotor) -> float:
    """Fastest steady level flight [m/s]; infinite where drag does not limit it below 100 m/s."""
    if steady_thrust(quadrotor, FASTEST) <= quadrotor.max_acceleration:
        return math.inf
    low, high = 0.0, FASTEST
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if steady_thrust(quadrotor, middle) <= quadrotor.max_acceleration else (low, middle)
    return low


def corner_radii(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radius of the circle through each inner point and its neighbours [m], shape (points - 2,); infinite on a straight line."""
    before, after = points[1:-1] - points[:-2], points[2:] - points[1:-1]
    across = np.linalg.norm(np.cross(before, after), axis=1)
    sides = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1) * np.linalg.norm(before + after, axis=1)
    turning_back = np.einsum("ij,ij->i", before, after) < 0
    straight = np.where(turning_back, 0.0, np.inf)
    return np.where(across > 1e-9, sides / np.maximum(2 * across, 1e-9), straight)


def rough_top_speed(race: Race) -> float:
    """Top speed around the track [m/s] of a point mass on circular arcs, without planning: good to about 20 %."""
    points = np.vstack([race.track.start, race.track.waypoints])
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    planned, drag = race.planning_model, race.planning_drag
    thrust = math.sqrt(max(planned.max_acceleration**2 - planned.gravity**2, 0.0))
    squares = np.concatenate([[0.0], thrust * corner_radii(points), [np.inf]])  # v^2 <= a r
    terminal = (thrust / drag) ** 2 if drag > 0 else np.inf
    if race.planning.dynamics is PlanDynamics.FULL:
        terminal = min(terminal, top_speed(planned) ** 2)
    squares = np.minimum(squares, terminal)
    for i, length in enumerate(lengths):
        push = max(thrust - drag * math.sqrt(squares[i]), 0.0)
        squares[i + 1] = min(squares[i + 1], squares[i] + 2 * push * length)
    for i in reversed(range(len(lengths))):
        squares[i] = min(squares[i], squares[i + 1] + 2 * thrust * lengths[i])
    return float(np.sqrt(squares.max()))


def steady_share(race: Race) -> float | None:
    """Share of the vehicle's thrust [-] that the longest leg takes at the plan's steady speed, drag and climb included.

    None where no leg is long enough for the plan to settle at a steady speed, twice v^2 over its level acceleration.
    """
    points = np.vstack([race.track.start, race.track.waypoints])
    legs = np.diff(points, axis=0)
    lengths = np.linalg.norm(legs, axis=1)
    longest = int(lengths.argmax())
    slope = float(legs[longest, 2] / lengths[longest])  # sine of the climb angle
    level = math.sqrt(1 - slope**2)
    speed = _planned_steady_speed(race, slope)
    push = math.sqrt(max(race.planning_model.max_acceleration**2 - race.planning_model.gravity**2, 0.0))
    if speed is None or lengths[longest] * push < 2 * speed**2:
        return None
    return steady_thrust(race.vehicle, speed * level, speed * slope) / race.vehicle.max_acceleration


def _planned_steady_speed(race: Race, slope: float) -> float | None:
    """Speed [m/s] at which the plan's drag takes all of the plan's thrust; None where that is beyond 100 m/s.

    Args:
        race: with the settings of its plan.
        slope: sine of the climb angle.
    """
    planned, drag = race.planning_model, race.planning_drag
    if race.planning.dynamics is PlanDynamics.IDEAL:
        root = math.sqrt(max(planned.max_acceleration**2 - planned.gravity**2 * (1 - slope**2), 0.0))
        speed = max(root - planned.gravity * slope, 0.0) / drag if drag > 0 else math.inf  # (c v)^2 + 2 c v g slope + g^2 = a^2
        return speed if math.isfinite(speed) else None
    if race.planning.v_max is not None:
        planned = planned.model_copy(update={"drag": (drag, drag, drag)})
    level = math.sqrt(1 - slope**2)
    low, high = 0.0, FASTEST
    if steady_thrust(planned, high * level, high * slope) <= planned.max_acceleration:
        return None
    for _ in range(40):
        speed = (low + high) / 2
        low, high = (speed, high) if steady_thrust(planned, speed * level, speed * slope) <= planned.max_acceleration else (low, speed)
    return low


def _pitch_excess(quadrotor: Quadrotor, pitch: float, speed: float, climb: float) -> float:
    """Gravity along the nose minus drag along it [m/s^2]: grows with pitch, zero in steady flight."""
    forward = speed * math.cos(pitch) - climb * math.sin(pitch)
    root_thrust = math.sqrt(quadrotor.rotor_count) * math.sqrt(
        quadrotor.mass * max(_carried(quadrotor, pitch, speed, climb), 0.0)
    )  # of the rotor thrusts
    linear = quadrotor.drag[0] + quadrotor.rotor_drag * root_thrust / quadrotor.mass
    quadratic = quadrotor.body_drag[0] / quadrotor.mass * abs(forward)
    return quadrotor.gravity * math.sin(pitch) - (linear + quadratic) * forward


def _carried(quadrotor: Quadrotor, pitch: float, speed: float, climb: float) -> float:
    """Thrust per mass [m/s^2] that carries weight and drag along body z."""
    upward = speed * math.sin(pitch) + climb * math.cos(pitch)
    drag = quadrotor.drag[2] * upward + quadrotor.body_drag[2] / quadrotor.mass * upward * abs(upward)
    return quadrotor.gravity * math.cos(pitch) + drag
