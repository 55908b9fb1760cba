"""Flatness: attitudes, body rates and thrusts that follow from a motion (Mellinger and Kumar, ICRA 2011).

    z_body = f / |f|,   thrust = |f|

of the thrust vector f (`thrust_vectors`). The turn about z_body is free: it follows a yaw, or there is none.
Rates are the turns between attitudes, torques follow from rates, and rotor thrusts from both.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hotlap.race.quadrotor import Quadrotor
from hotlap.reference.attitude import continuous, follow_axes, thrust_axis, turn_rates
from hotlap.reference_files.thrust_vectors import axes_of

Floats = NDArray[np.float64]

PARALLEL = 0.05  # sine of the angle between heading and thrust axis below which a yaw says nothing
SMOOTHED = {1: 5, 2: 11}  # rows of the window, by how often something is differentiated


def slopes(values: Floats, period: float, times: int = 1) -> tuple[Floats, ...]:
    """First derivatives, and second ones, by local parabolas (Savitzky and Golay, 1964).

    Args:
        values: shape (rows, n), evenly spaced.
        period: [s] between rows.
        times: 1 for the first derivative, 2 for the first and the second, over a wider window.
    """
    from scipy.signal import savgol_filter  # noqa: PLC0415  only for what is incomplete

    window = min(SMOOTHED[times], len(values) - 1 + len(values) % 2)
    return tuple(np.asarray(savgol_filter(values, window, 2, deriv=k, delta=period, axis=0)) for k in range(1, times + 1))


def attitudes_along(vectors: Floats, start: Floats) -> Floats:
    """Attitudes along thrust vectors that never turn about their own z axis, shape (rows, 4).

    Args:
        vectors: shape (rows, 3) (world).
        start: shape (4,) attitude that is turned to the first of them, by the shortest way.
    """
    return continuous(follow_axes(axes_of(vectors), start))


def attitudes_with_yaw(vectors: Floats, yaw: Floats) -> Floats:
    """Attitudes along thrust vectors whose left axis is square to a heading, shape (rows, 4): left = up x (cos yaw, sin yaw, 0).

    Where the thrust is level and along the heading, a yaw says nothing: left stays where it was. It keeps its side beyond that, so that
    a loop is flown as one.

    Args:
        vectors: shape (rows, 3) (world).
        yaw: shape (rows,) [rad].
    """
    up = axes_of(vectors)
    wanted = np.cross(up, np.stack([np.cos(yaw), np.sin(yaw), np.zeros_like(yaw)], axis=1))
    left, before = np.empty_like(up), np.array([-np.sin(yaw[0]), np.cos(yaw[0]), 0.0])
    for k, (side, axis) in enumerate(zip(wanted, up, strict=True)):
        size = float(np.linalg.norm(side))
        side = side / size * (1.0 if side @ before >= 0 else -1.0) if size > PARALLEL else before - axis * (axis @ before)  # noqa: PLW2901
        before = left[k] = side / np.linalg.norm(side)
    return continuous(_quaternions(np.stack([np.cross(left, up), left, up], axis=2)))


def attitudes_of_angles(angles: Floats) -> Floats:
    """Attitudes of roll, pitch and yaw (about x, then y, then z of the body turned back: the usual order), shape (rows, 4).

    Args:
        angles: shape (rows, 3) [rad]; a positive pitch lowers the nose.
    """
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles.T / 2), np.sin(angles.T / 2)
    parts = (cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy)
    return continuous(np.stack(parts, axis=1))


def rates_of(attitudes: Floats, period: float) -> Floats:
    """Body rates of attitudes, shape (rows, 3) [rad/s]: at each row the mean of the turns before and behind it."""
    turns = turn_rates(attitudes, period)
    return np.vstack([turns[:1], (turns[:-1] + turns[1:]) / 2, turns[-1:]])


def along_axis(vectors: Floats, attitudes: Floats) -> Floats:
    """Thrust per mass: what of the thrust vectors lies along body z, never negative, shape (rows,) [m/s^2]."""
    return np.maximum((vectors * thrust_axis(attitudes)).sum(axis=1), 0.0)


def rotor_thrusts(quadrotor: Quadrotor, thrust: Floats, rates: Floats, period: float) -> Floats:
    """Rotor thrusts that give a thrust and the torques of rates, shape (rows, n) [N].

    torque = J dw/dt + w x J w. Where that would need a rotor to pull, less torque is given; the sum is always that of the thrust.

    Args:
        quadrotor: its mass, inertia and rotors count.
        thrust: shape (rows,) [m/s^2] per mass.
        rates: shape (rows, 3) [rad/s] (body).
        period: [s] between rows.
    """
    inertia = quadrotor.inertia_vector
    torques = inertia * slopes(rates, period)[0] + np.cross(rates, inertia * rates)
    rotors = quadrotor.rotor_count
    mixing, wanted = np.vstack([np.ones(rotors), quadrotor.torque_matrix]), np.hstack([np.zeros((len(thrust), 1)), torques])
    steering = np.linalg.solve(mixing, wanted.T).T if rotors == 4 else wanted @ np.linalg.pinv(mixing).T
    hover = quadrotor.mass * thrust[:, None] / rotors
    deepest = np.maximum(-steering.min(axis=1, keepdims=True), 1e-12)
    return hover + np.minimum(hover / deepest, 1.0) * steering


def _quaternions(matrices: Floats) -> Floats:
    """Quaternions (w, x, y, z) of rotation matrices, shape (rows, 3, 3) -> (rows, 4)."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415  only for what is incomplete

    return np.roll(Rotation.from_matrix(matrices).as_quat(), 1, axis=1)
