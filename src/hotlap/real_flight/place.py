"""Place: where the world of a race lies in that of a vehicle."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from hotlap.core.errors import InputError
from hotlap.core.records import Floats
from hotlap.real_flight.link import Seen
from hotlap.real_flight.paths import level, yaw_of
from hotlap.reference.attitude import product

HERE = "here"
FORM = f"x, y, z [m] and yaw [deg] of the race's origin in the vehicle's own world, or '{HERE}': the race starts above where it stands"


@dataclass(frozen=True)
class Place:
    """A shift, and a turn about z.

    Attributes:
        origin: shape (3,) [m] the race's origin in the vehicle's world.
        yaw: [rad] the race's x axis there.
    """

    origin: Floats
    yaw: float = 0.0

    def seen(self, seen: Seen) -> Seen:
        """What was seen, in the world of the race."""
        state = seen.state.copy()
        if not self.yaw:
            state[:3] -= self.origin
            return dataclasses.replace(seen, state=state)
        state[:3] = self._turned(seen.state[:3] - self.origin, -self.yaw)
        state[3:7] = product(level(-self.yaw)[None], seen.state[None, 3:7])[0]
        state[7:10] = self._turned(seen.state[7:10], -self.yaw)
        return dataclasses.replace(seen, state=state)

    def told(self, state: Floats) -> Floats:
        """A state of the race, shape (13,), in the vehicle's world."""
        told = state.copy()
        if not self.yaw:
            told[:3] += self.origin
            return told
        told[:3] = self._turned(state[:3], self.yaw) + self.origin
        told[3:7] = product(level(self.yaw)[None], state[None, 3:7])[0]
        told[7:10] = self._turned(state[7:10], self.yaw)
        return told

    def told_all(self, states: Floats) -> Floats:
        """States of the race, shape (n, 13), in the vehicle's world."""
        return np.array([self.told(state) for state in states])

    def turned(self, vector: Floats) -> Floats:
        """A vector of the race, shape (3,), in the vehicle's world."""
        return self._turned(vector, self.yaw)

    @staticmethod
    def _turned(vector: Floats, yaw: float) -> Floats:
        c, s = math.cos(yaw), math.sin(yaw)
        return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2]])


def read_place(text: str) -> Place | None:
    """A place as it was written; None: where the vehicle stands.

    Raises:
        InputError: it is none.
    """
    if text.strip() == HERE:
        return None
    try:
        numbers = np.array([float(part) for part in text.split(",")])
    except ValueError:
        numbers = np.empty(0)
    if numbers.shape != (4,) or not np.isfinite(numbers).all():
        raise InputError("", "origin", f"must be {FORM}; not '{text}'")
    return Place(numbers[:3], math.radians(numbers[3]))


def place_here(state: Floats, start: Floats, attitude: Floats, floor: float) -> Place:
    """The place at which a race starts above the vehicle, in the direction in which it looks.

    Args:
        state: shape (13,) of the vehicle, in its own world, on the ground.
        start: shape (3,) [m] (race).
        attitude: shape (4,) at the start (race).
        floor: [m] (race) height of the ground.
    """
    yaw = yaw_of(state[3:7]) - yaw_of(attitude)
    there = Place(np.zeros(3), yaw).turned(np.array([start[0], start[1], floor]))
    return Place(state[:3] - there, yaw)
