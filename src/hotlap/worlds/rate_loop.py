"""Rate loop: from commands to rotor thrusts, as the flight controller of the built-in world does it, for simulators that take thrusts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hotlap.race.quadrotor import Quadrotor

Floats = NDArray[np.float64]


class RateLoop:
    """Turns commands into the thrusts that rotors are asked for; computed anew in every step of a simulator, in numpy.

        torque = J k (w_cmd - w) + w x J w - damping (present torque - w x J w)

    Args:
        quadrotor: that flies: its gains, its rotors and their limits.
        known_as: the quadrotor as the loop knows it: mass, inertia and mixer; None: as it is.
    """

    def __init__(self, quadrotor: Quadrotor, known_as: Quadrotor | None = None) -> None:
        known = known_as or quadrotor
        self._mass, self._inertia = known.mass, known.inertia_vector
        self._mixer = np.linalg.inv(np.vstack([np.ones(4), known.torque_matrix]))
        self._gain, self._damping = np.array(quadrotor.rate_gain), quadrotor.torque_damping
        self._torques, self._limits = quadrotor.torque_matrix, quadrotor.rotor_thrust

    def __call__(self, states: Floats, rotor_thrusts: Floats, commands: Floats) -> Floats:
        """The thrusts that the rotors are asked for, within their limits.

        Args:
            states: shape (..., 13), of which the body rates [rad/s] are used.
            rotor_thrusts: shape (..., 4) [N] that the rotors give now.
            commands: shape (..., 4): thrust per mass [m/s^2] and body rates [rad/s].

        Returns:
            Shape (..., 4) [N], in the order of the vehicle's layout.
        """
        rates = states[..., 10:13]
        gyroscopic = np.cross(rates, self._inertia * rates)
        wanted = self._inertia * self._gain * (commands[..., 1:] - rates) + gyroscopic
        torque = wanted - self._damping * (rotor_thrusts @ self._torques.T - gyroscopic)
        asked = np.concatenate([self._mass * commands[..., :1], torque], axis=-1)
        return np.clip(asked @ self._mixer.T, *self._limits)
