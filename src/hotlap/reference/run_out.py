"""Run-out: what lies beyond the end of a reference, so that a controller's horizon never meets a wall.

A horizon that is clamped to the last row asks the drone to stand still there at full speed, and every controller diverges
in the last second. The run-out slows down instead, as a drone would.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from hotlap.reference.attitude import follow_axes, thrust_axis, turn_rates
from hotlap.reference.reference import Reference

Floats = NDArray[np.float64]

RUN_OUT = 9.0  # s: longer than the longest horizon
BLEND = 0.6  # s, from the last acceleration to slowing down
SLOWING = 2.5  # s, time constant of the speed afterwards
LARGEST_RATE = 8.0  # rad/s, of the thrust axis
WEIGHTLESS = 1e-3  # m/s^2: below this thrust has no direction


def extend(reference: Reference, gravity: float, drag: float, acceleration: Floats | None = None) -> Reference:
    """A reference with its run-out, which replaces whatever lay behind its planned rows.

    Position, velocity and acceleration go on without a jump, the attitude turns by the shortest way. The run-out itself has
    no drag: what thrust a controller needs there is a matter of its own model.

    Args:
        reference: planned or read.
        gravity: [m/s^2] of its model.
        drag: [1/s] linear drag of its model.
        acceleration: shape (3,) [m/s^2] (world) at the last planned row, of a model with other drags. None: by thrust, gravity and drag.
    """
    rows, count = reference.planned_rows, round(RUN_OUT / reference.period)
    first = _last_acceleration(reference, gravity, drag) if acceleration is None else acceleration
    position, velocity, accelerations = _slow_down(reference, first, count)
    thrusts = accelerations + np.array([0.0, 0.0, gravity])
    attitude, rates = _attitudes(thrusts, reference.attitude[rows - 1], reference.period)
    return dataclasses.replace(
        reference,
        position=np.vstack([reference.position[:rows], position]),
        attitude=np.vstack([reference.attitude[:rows], attitude]),
        velocity=np.vstack([reference.velocity[:rows], velocity]),
        rates=np.vstack([reference.rates[:rows], rates]),
        thrust=np.append(reference.thrust[:rows], np.linalg.norm(thrusts, axis=1)),
        rotor_thrusts=np.vstack([reference.rotor_thrusts[:rows], np.full((count, reference.rotor_thrusts.shape[1]), np.nan)]),
    )


def _last_acceleration(reference: Reference, gravity: float, drag: float) -> Floats:
    """Acceleration at the last planned row by thrust, gravity and linear drag, shape (3,) [m/s^2] (world)."""
    last = reference.planned_rows - 1
    acceleration = reference.thrust[last] * thrust_axis(reference.attitude[last]) - drag * reference.velocity[last]
    acceleration[2] -= gravity
    return acceleration


def _slow_down(reference: Reference, first: Floats, count: int) -> tuple[Floats, Floats, Floats]:
    """Positions, velocities and accelerations (world) of the rows after the last planned one, each of shape (count, 3).

    Args:
        reference: its last planned row is where to begin.
        first: shape (3,) [m/s^2] (world) acceleration there.
        count: number of rows.
    """
    last, h = reference.planned_rows - 1, reference.period
    p, v, a = reference.position[last], reference.velocity[last], first
    motion = np.empty((3, count, 3))
    for k in range(count):
        share = min((k + 1) * h / BLEND, 1.0)
        share = share * share * (3 - 2 * share)  # smoothstep
        after = (1 - share) * first - share * (v + h * a) / SLOWING
        p, v, a = p + h * v + h * h * (2 * a + after) / 6, v + h * (a + after) / 2, after  # acceleration linear in between
        motion[:, k] = p, v, a
    return motion[0], motion[1], motion[2]


def _attitudes(thrusts: Floats, attitude: Floats, period: float) -> tuple[Floats, Floats]:
    """Attitudes that tilt to given thrusts per mass (world), and body rates, shapes (count, 4) and (count, 3).

    Args:
        thrusts: shape (count, 3) [m/s^2].
        attitude: shape (4,) just before.
        period: [s] between rows.
    """
    norms = np.linalg.norm(thrusts, axis=1)
    known = np.append(0, np.where(norms > WEIGHTLESS, np.arange(1, len(norms) + 1), 0))
    axes = np.vstack([thrust_axis(attitude), thrusts / np.maximum(norms, WEIGHTLESS)[:, None]])
    axes = axes[np.maximum.accumulate(known)][1:]  # in free fall the last direction stays
    attitudes = follow_axes(axes, attitude, LARGEST_RATE * period)
    turns = turn_rates(np.vstack([attitude, attitudes]), period)
    return attitudes, np.vstack([(turns[:-1] + turns[1:]) / 2, turns[-1:]])
