"""Paths: what is flown besides the race itself: to its start, and from its end to a stand, as references of the same form."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise

import numpy as np

from hotlap.core.records import Floats
from hotlap.race.race import Race
from hotlap.reference.attitude import continuous, follow_axes, turn_rates
from hotlap.reference.reference import PERIOD, Reference
from hotlap.reference.scenario import Scenario
from hotlap.reference.segments import SegmentClass, Segments

BLEND = 0.6  # s from the last acceleration of the race to braking, as in a run-out
EASING = 0.6  # s, time constant of the last of the speed
LEVELLING = 4.0  # 1/s: damping of the way back to the height at which it began
FALL = 5.0  # m/s^2 downwards at most
BRAKING_SHARE = 0.5  # of the level acceleration that the controller may command
THRUST_SHARE = 0.9  # of the thrust that it may command
STANDING, LONGEST = 0.02, 40.0  # m/s, s: when braking is over
STAND = 2.0  # s at the end
LEAST_TIME = 1.0  # s of a path from rest to rest
UP = np.array([0.0, 0.0, 1.0])


def yaw_of(attitude: Floats) -> float:
    """Heading [rad] of an attitude, shape (4,)."""
    w, x, y, z = attitude.tolist()
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def level(yaw: float) -> Floats:
    """The level attitude of a heading [rad], shape (4,)."""
    return np.array([math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)])


def path_from_rest(points: Floats, yaws: tuple[float, float], speed: float, acceleration: float, gravity: float) -> Reference:
    """Straight lines between points, each flown from rest to rest with the least jerk, and a stand at the last one.

    Args:
        points: shape (n, 3) [m] (world), at least one.
        yaws: [rad] at the first and at the last; it turns by the shorter way, as the drone goes.
        speed: [m/s] at most.
        acceleration: [m/s^2] at most.
        gravity: [m/s^2].
    """
    legs = [_leg(a, b, speed, acceleration) for a, b in pairwise(points)]
    still = round(STAND / PERIOD)
    position = np.vstack([*(leg[0] for leg in legs), np.tile(points[-1], (still, 1))])
    velocity = np.vstack([*(leg[1] for leg in legs), np.zeros((still, 3))])
    accelerations = np.vstack([*(leg[2] for leg in legs), np.zeros((still, 3))])
    moving = max(len(position) - still, 1)
    turn = math.remainder(yaws[1] - yaws[0], 2 * math.pi)
    shares = np.clip(np.arange(len(position)) / moving, 0, 1)
    headings = yaws[0] + turn * (3 - 2 * shares) * shares**2
    thrusts = accelerations + gravity * UP
    norms = np.linalg.norm(thrusts, axis=1)
    rows = zip(thrusts / norms[:, None], headings.tolist(), strict=True)
    attitude = continuous(np.vstack([follow_axes(axis[None], level(yaw)) for axis, yaw in rows]))
    rates = turn_rates(attitude, PERIOD)
    unknown = np.full((len(position), 4), np.nan)
    duration = (len(position) - 1) * PERIOD
    whole = np.vstack([rates, np.zeros((1, 3))])
    return Reference(position, attitude, velocity, whole, norms, unknown, np.array([duration]), duration)


def scenario_of(race: Race, path: Reference) -> Scenario:
    """A path as something to fly, with the race's controller."""
    return Scenario(race, path, Segments(np.zeros(1), (SegmentClass.FLAT,), path.duration))


def offset_free(scenario: Scenario, *, on: bool = True) -> Scenario:
    """The same with a controller that learns what thrust is worth and what else acts, or with one that does not."""
    controller = scenario.race.controller.model_copy(update={"offset_free": on})
    return dataclasses.replace(scenario, race=scenario.race.model_copy(update={"controller": controller}))


def with_braking(scenario: Scenario) -> Scenario:
    """A race that ends with a stand: its plan, then braking in place of the run-out, which would go on for ever.

    The acceleration goes over into one against the velocity, of a size that the controller can hold, until the drone stands.
    """
    reference, gravity = scenario.reference, scenario.race.control_model.gravity
    rows, last = reference.planned_rows, reference.planned_rows - 1
    slope = np.gradient(reference.velocity[max(rows - 3, 0) : rows], reference.period, axis=0)[-1]
    position, velocity, accelerations = _brake(
        reference.position[last], reference.velocity[last], slope, reference.period, braking_of(scenario)
    )
    thrusts = accelerations + gravity * UP
    norms = np.linalg.norm(thrusts, axis=1)
    attitude = follow_axes(thrusts / norms[:, None], reference.attitude[last], 8.0 * reference.period)
    whole = np.vstack([reference.attitude[:rows], attitude])
    rates = np.vstack([turn_rates(whole[last:], reference.period), np.zeros((1, 3))])[1:]
    return dataclasses.replace(
        scenario,
        reference=dataclasses.replace(
            reference,
            position=np.vstack([reference.position[:rows], position]),
            attitude=whole,
            velocity=np.vstack([reference.velocity[:rows], velocity]),
            rates=np.vstack([reference.rates[:rows], rates]),
            thrust=np.append(reference.thrust[:rows], norms),
            rotor_thrusts=np.vstack([reference.rotor_thrusts[:rows], np.full((len(position), reference.rotor_thrusts.shape[1]), np.nan)]),
        ),
    )


def braking_of(scenario: Scenario) -> float:
    """[m/s^2] by which a race is braked at its end."""
    gravity, most = scenario.race.control_model.gravity, THRUST_SHARE * scenario.planned_thrust[1]
    return BRAKING_SHARE * math.sqrt(max(most**2 - gravity**2, 1.0))


def _brake(p: Floats, v: Floats, first: Floats, h: float, most: float) -> tuple[Floats, Floats, Floats]:
    """Positions, velocities, accelerations (world) from a motion to a stand at the same height, each of shape (rows, 3)."""
    motion, a, k, height = [], first, 0, p[2]
    while k * h < LONGEST and (k * h < BLEND or np.linalg.norm(v) > STANDING):
        k += 1
        share = min(k * h / BLEND, 1.0)
        share = share * share * (3 - 2 * share)  # smoothstep
        slowing = -(v + h * a) / max(EASING, float(np.linalg.norm(v)) / most)
        slowing[2] = -((LEVELLING / 2) ** 2) * (p[2] - height) - LEVELLING * (v[2] + h * a[2])
        slowing[2] = min(max(slowing[2], -FALL), most)
        after = (1 - share) * first + share * slowing
        p, v, a = p + h * v + h * h * (2 * a + after) / 6, v + h * (a + after) / 2, after  # acceleration linear in between
        motion.append((p, v, a))
    motion += [(p, np.zeros(3), np.zeros(3))] * round(STAND / h)
    position, velocity, acceleration = (np.array(part) for part in zip(*motion, strict=True))
    return position, velocity, acceleration


def _leg(a: Floats, b: Floats, speed: float, acceleration: float) -> tuple[Floats, Floats, Floats]:
    """A straight line from rest to rest with the least jerk: positions, velocities, accelerations without the last row."""
    way = b - a
    length = float(np.linalg.norm(way))
    time = max(1.875 * length / speed, math.sqrt(5.774 * length / acceleration), LEAST_TIME if length else 0.0)
    s = (np.arange(round(time / PERIOD)) * PERIOD / max(time, PERIOD))[:, None]
    position = a + way * s**3 * (10 - 15 * s + 6 * s**2)
    velocity = way * 30 * s**2 * (1 - s) ** 2 / max(time, PERIOD)
    return position, velocity, way * 60 * s * (1 - 3 * s + 2 * s**2) / max(time, PERIOD) ** 2
