"""A module such as a user builds for flightlib; it flies as flightlib does, in numpy.

Forces act as they are at the beginning of a step, the rest of the step is integrated by Runge and Kutta's rule; rotor speeds follow
with one time constant, whoever leaves the box at its top is put on its floor.
"""

from __future__ import annotations

import numpy as np

BOX = 100.0
MASS, INERTIA, GRAVITY = 0.73, np.array([0.00791138, 0.00791138, 0.01230658]), 9.81
MOST_THRUST, MOTOR_TIME = 11.222464, 1e-4
ALLOCATION = np.array(
    [
        [1.0, 1.0, 1.0, 1.0],
        [0.120208, -0.120208, -0.120208, 0.120208],
        [-0.120208, -0.120208, 0.120208, 0.120208],
        [0.016, -0.016, 0.016, -0.016],
    ]
)


class Quadrotor:
    def __init__(self) -> None:
        self._state, self._speeds = np.zeros(13), np.zeros(4)
        self.steps: list[float] = []

    def reset(self) -> None:
        self._state, self._speeds = np.zeros(13), np.zeros(4)

    def set_state(self, state) -> None:
        self._state = np.array(state, dtype=float)

    def state(self) -> list[float]:
        return self._state.tolist()

    def rotor_thrusts(self) -> list[float]:
        return (self._speeds**2).tolist()

    def step(self, thrusts, duration: float) -> None:
        self.steps.append(duration)
        left = np.exp(-duration / MOTOR_TIME)
        self._speeds = left * self._speeds + (1 - left) * np.sqrt(np.clip(thrusts, 0, MOST_THRUST))
        force, *torque = ALLOCATION @ self._speeds**2
        acceleration = force / MASS * _up(self._state[3:7]) - [0, 0, GRAVITY]

        def rate(x: np.ndarray) -> np.ndarray:
            (w, i, j, k), (p, q, r) = x[3:7], x[10:]
            turn = [-i * p - j * q - k * r, w * p + j * r - k * q, w * q + k * p - i * r, w * r + i * q - j * p]
            return np.concatenate([x[7:10], np.array(turn) / 2, acceleration, (torque - np.cross(x[10:], INERTIA * x[10:])) / INERTIA])

        x, h = self._state, duration
        first = rate(x)
        second = rate(x + h / 2 * first)
        third = rate(x + h / 2 * second)
        after = x + h / 6 * (first + 2 * second + 2 * third + rate(x + h * third))
        after[3:7] /= np.linalg.norm(after[3:7])
        if not -BOX < after[2] < BOX:
            after[2], after[9:13] = -BOX, 0.0
        self._state = after


def _up(attitude: np.ndarray) -> np.ndarray:
    w, x, y, z = attitude
    return np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
