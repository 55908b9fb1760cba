"""Sticks: what a pilot's hands do for a command of the controller, and where the firmware's motors are on the vehicle."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hotlap.race.quadrotor import Quadrotor, RotorLayout

Floats = NDArray[np.float64]
Channels = NDArray[np.uint16]

LOWEST, MIDDLE, HIGHEST = 1000, 1500, 2000  # us
CUT = 950  # us: a throttle below its range, which arming asks for
ROUNDED: Final = 0.0015  # of throttle, lost between a stick and a motor by rounding down three times
CHANNELS, THROTTLE, YAW, SWITCH = 16, 2, 3, 4
TURNS: Final = np.array([1.0, 1.0, -1.0])  # the sticks' directions in hotlap's body frame: roll, pitch, yaw
ROTORS: Final = {RotorLayout.X: np.array([2, 0, 3, 1]), RotorLayout.PLUS: np.array([2, 1, 3, 0])}
"""Which of the motors in a packet is at each rotor, in the order of the layout."""


class Sticks:
    """Turns commands into channels.

    Args:
        quadrotor: that flies.
        full_stick: [deg/s] that a full stick means.
        idle: motor output at no throttle [-].
    """

    def __init__(self, quadrotor: Quadrotor, full_stick: int, idle: float) -> None:
        self._share = quadrotor.mass / (4 * quadrotor.rotor_thrust[1])
        self._scale = TURNS * (HIGHEST - MIDDLE) / math.radians(full_stick)
        self._idle = idle

    def channels(self, command: Floats) -> Channels:
        """Channels for a command, shape (16,) [us].

        Args:
            command: shape (4,): thrust per mass [m/s^2] and body rates [rad/s].
        """
        output = math.sqrt(max(float(command[0]), 0.0) * self._share)
        throttle = (output - self._idle) / (1 - self._idle) + ROUNDED
        raw = np.full(CHANNELS, float(LOWEST))
        roll, pitch, yaw = MIDDLE + self._scale * command[1:]
        raw[: SWITCH + 1] = roll, pitch, LOWEST + (HIGHEST - LOWEST) * throttle, yaw, HIGHEST
        return np.clip(np.rint(raw), LOWEST, HIGHEST).astype(np.uint16)


def resting(armed: bool) -> Channels:
    """Channels of a pilot who waits on the ground, shape (16,) [us]."""
    raw = np.full(CHANNELS, LOWEST, dtype=np.uint16)
    raw[: SWITCH + 1] = MIDDLE, MIDDLE, CUT, MIDDLE, HIGHEST if armed else LOWEST
    return raw
