"""States: whole states of a vehicle from its messages: ODOMETRY, or LOCAL_POSITION_NED together with an attitude."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hotlap.core.records import Floats
from hotlap.real_flight.mavlink.frames import attitude_of_angles, attitude_of_quaternion, motion_of_position, state_of_odometry, turned_on

APART = 0.05  # s between a position and an attitude that are one state
FORGET = 1.0  # s after which a better source that is silent is forgotten


class States:
    """Makes states of messages; the best source that speaks counts: ODOMETRY, then ATTITUDE_QUATERNION before ATTITUDE.

    Attributes:
        resets: how often the estimate has jumped, as ODOMETRY counts.
        unknown_frames: frames of ODOMETRY messages that are not known here.
    """

    def __init__(self) -> None:
        self.resets, self.unknown_frames = 0, ""
        self._odometry = self._quaternion = -math.inf
        self._attitude: tuple[float, Floats] | None = None
        self._waiting: tuple[float, Floats] | None = None
        self._last = -math.inf

    def hear(self, message: Any) -> tuple[float, Floats] | None:
        """Take in a message.

        Returns:
            Time of the vehicle's clock [s] and state, shape (13,), where there is one that is newer than the last.
        """
        made = self._make(message)
        if made is None or made[0] <= self._last:
            return None
        self._last = made[0]
        return made

    def _make(self, message: Any) -> tuple[float, Floats] | None:
        kind = message.get_type()
        if kind == "ODOMETRY":
            stamp, state = 1e-6 * message.time_usec, state_of_odometry(message)
            if message.quality < 0:
                return None  # the estimator has failed, and says so
            if state is None:
                self.unknown_frames = f"{message.frame_id} and {message.child_frame_id}"
                return None
            self._odometry, self.resets = stamp, message.reset_counter
            return stamp, state
        if kind not in {"LOCAL_POSITION_NED", "ATTITUDE_QUATERNION", "ATTITUDE"}:
            return None
        stamp = 1e-3 * message.time_boot_ms
        if stamp - self._odometry < FORGET:
            return None
        if kind == "LOCAL_POSITION_NED":
            missed, self._waiting = self._waiting, (stamp, motion_of_position(message))
            if self._attitude is not None and self._attitude[0] >= stamp:
                return self._together()
            return None if missed is None else self._pair(missed)
        if kind == "ATTITUDE_QUATERNION":
            self._quaternion, self._attitude = stamp, (stamp, attitude_of_quaternion(message))
        elif stamp - self._quaternion >= FORGET:
            self._attitude = stamp, attitude_of_angles(message)
        return self._together() if self._waiting is not None else None

    def _together(self) -> tuple[float, Floats] | None:
        """The position that waits, with the attitude that there is."""
        waiting, self._waiting = self._waiting, None
        return None if waiting is None else self._pair(waiting)

    def _pair(self, waiting: tuple[float, Floats]) -> tuple[float, Floats] | None:
        """A position with the attitude at its time; None: there is none that is near."""
        stamp, motion = waiting
        if self._attitude is None or abs(stamp - self._attitude[0]) > APART:
            return None
        turned = turned_on(self._attitude[1], stamp - self._attitude[0])
        return stamp, np.concatenate([motion[:3], turned[:4], motion[3:], turned[4:]])
