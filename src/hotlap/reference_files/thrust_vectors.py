"""Thrust vectors: what rotors have to give along a motion, with the drags of a quadrotor.

    f = dv/dt + g e3 + R D(R^T v),   per mass; the thrust axis R e3 points along f

Drag depends on the attitude and the attitude on drag, so that both are found in turns.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.race.airframe import airframe_parameters
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import PlanDynamics, Race
from hotlap.reference.attitude import thrust_axis

Floats = NDArray[np.float64]

ROUNDS = 30  # of attitude and drag in turns
SHARE = 0.5  # of each turn that is gone: with a drag that grows with the tilt, whole ones swing
CLOSE = 1e-4  # m/s^2: what a round may still change
WEIGHTLESS = 0.5  # m/s^2: below this thrust has no direction that could be told from noise


def planned_thrust(race: Race, velocity: Floats, acceleration: Floats, attitude: Floats | None = None) -> Floats:
    """What the rotors of the planning model give along a motion, shape (rows, 3) [m/s^2] (world), with the drag that the race plans with.

    Args:
        race: its planning model and settings count.
        velocity: shape (rows, 3) [m/s] (world).
        acceleration: shape (rows, 3) [m/s^2] (world).
        attitude: shape (rows, 4) where it is known.
    """
    model, settings = race.planning_model, race.planning
    if settings.dynamics is PlanDynamics.IDEAL:
        return acceleration + np.array([0.0, 0.0, model.gravity]) + race.planning_drag * velocity
    if settings.v_max is not None:
        model = model.model_copy(update={"drag": (race.planning_drag,) * 3})
    return with_drag(model, velocity, acceleration, attitude)


def with_drag(quadrotor: Quadrotor, velocity: Floats, acceleration: Floats, attitude: Floats | None = None) -> Floats:
    """What the rotors of a quadrotor give along a motion, with all its drags, shape (rows, 3) [m/s^2] (world).

    Args:
        quadrotor: whose drags and gravity count.
        velocity: shape (rows, 3) [m/s] (world).
        acceleration: shape (rows, 3) [m/s^2] (world).
        attitude: shape (rows, 4) where it is known. None: it is what the thrust needs, with any yaw.
    """
    weight = acceleration + np.array([0.0, 0.0, quadrotor.gravity])
    if not any((*quadrotor.drag, *quadrotor.body_drag, quadrotor.rotor_drag)):
        return weight
    vectors = weight
    for _ in range(ROUNDS):
        known = _upright(axes_of(vectors)) if attitude is None else attitude
        change = weight + drag(quadrotor, known, velocity, np.linalg.norm(vectors, axis=1)) - vectors
        vectors = vectors + SHARE * change
        if np.abs(change).max() < CLOSE:
            break
    return vectors


def drag(quadrotor: Quadrotor, attitude: Floats, velocity: Floats, thrust: Floats) -> Floats:
    """Deceleration by all drags of a quadrotor, shape (rows, 3) [m/s^2] (world); its rotors are taken to give the same thrust.

    Args:
        quadrotor: whose drags.
        attitude: shape (rows, 4).
        velocity: shape (rows, 3) [m/s] (world).
        thrust: shape (rows,) [m/s^2] about what the rotors give.
    """
    rows = len(attitude)
    states = np.hstack([np.zeros((rows, 3)), velocity, attitude, np.zeros((rows, 3))])
    thrusts = np.tile(quadrotor.mass * thrust / quadrotor.rotor_count, (quadrotor.rotor_count, 1))
    parameters = np.tile(airframe_parameters(quadrotor)[:, None], rows)
    acceleration = np.asarray(_airframe(rows, quadrotor.rotor_count)(states.T, thrusts, parameters))[3:6].T
    return thrust_axis(attitude) * thrust[:, None] - np.array([0.0, 0.0, quadrotor.gravity]) - acceleration


@cache
def _airframe(rows: int, rotors: int) -> Any:
    """The equations of motion for so many rows at once."""
    from hotlap.dynamics.models import airframe  # noqa: PLC0415  CasADi, only where it is needed

    return airframe(rotors).map(rows)


def axes_of(vectors: Floats) -> Floats:
    """Directions of thrust, shape (rows, 3); in free fall the one before, or the next where there is none before."""
    norms = np.linalg.norm(vectors, axis=1)
    known = np.flatnonzero(norms > WEIGHTLESS)
    if not len(known):
        return np.tile([0.0, 0.0, 1.0], (len(vectors), 1))
    nearest = known[np.maximum(np.searchsorted(known, np.arange(len(vectors)), side="right") - 1, 0)]
    return vectors[nearest] / norms[nearest][:, None]


def _upright(axes: Floats) -> Floats:
    """Attitudes with given z axes, turned there by the shortest way from level, shape (rows, 4)."""
    x, y, z = axes.T
    attitudes = np.stack([1 + z, -y, x, np.zeros_like(x)], axis=1)
    attitudes[z < -1 + 1e-9] = [0.0, 1.0, 0.0, 0.0]
    return attitudes / np.linalg.norm(attitudes, axis=1, keepdims=True)
