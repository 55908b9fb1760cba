"""Geofence: the box that a real vehicle must not leave; outside of it no setpoint is sent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hotlap.core.errors import InputError
from hotlap.core.records import Floats
from hotlap.race.track import Track

MARGIN = 2.0  # m around the path, where nothing is said
FORM = "six numbers: x from, x to, y from, y to, z from, z to [m]"


@dataclass(frozen=True)
class Geofence:
    """A box in the world of the race.

    Attributes:
        low, high: shape (3,) [m], its corners.
    """

    low: Floats
    high: Floats

    def outside(self, point: Floats) -> bool:
        """Whether a point, shape (3,) [m], lies outside; one that is not finite does."""
        return not bool(((point >= self.low) & (point <= self.high)).all())

    @property
    def words(self) -> str:
        """Its sides, for people."""
        sides = (f"{axis} {low:.1f} to {high:.1f}" for axis, low, high in zip("xyz", self.low, self.high, strict=True))
        return f"{', '.join(sides)} m"

    def to_dict(self) -> dict[str, list[float]]:
        """Plain values."""
        return {"low": self.low.tolist(), "high": self.high.tolist()}


def geofence_of(path: Floats, track: Track, given: str = "", margin: float = MARGIN) -> Geofence:
    """The box that was given, or one around a path, within the track's own limits.

    Args:
        path: shape (n, 3) [m] of all that is to be flown.
        track: whose box, floor and ceiling hold, too; below a floor there is half a metre of room, for states are not exact.
        given: as `FORM` says; "": derived.
        margin: [m] around the path.

    Raises:
        InputError: it is no box, or the path leaves it.
    """
    if given:
        fence = _read(given)
    else:
        low, high = path.min(axis=0) - margin, path.max(axis=0) + margin
        if track.box is not None:
            low, high = np.maximum(low, np.array(track.box.low) - 0.5), np.minimum(high, np.array(track.box.high) + 0.5)
        if track.floor is not None:
            low[2] = max(low[2], track.floor - 0.5)
        if track.ceiling is not None:
            high[2] = min(high[2], track.ceiling + 0.5)
        fence = Geofence(low, high)
    beyond = [point for point in path if fence.outside(point)]
    if beyond:
        place = ", ".join(f"{value:.1f}" for value in beyond[0])
        raise InputError("", "geofence", f"the flight leaves it at ({place}) m: it needs {_needed(path)}, braking included")
    return fence


def _needed(path: Floats) -> str:
    return Geofence(path.min(axis=0), path.max(axis=0)).words


def _read(text: str) -> Geofence:
    """A box as it was written."""
    try:
        numbers = np.array([float(part) for part in text.split(",")])
    except ValueError:
        numbers = np.empty(0)
    if numbers.shape != (6,) or not np.isfinite(numbers).all():
        raise InputError("", "geofence", f"must be {FORM}, not '{text}'")
    low, high = numbers[::2], numbers[1::2]
    if (low >= high).any():
        axis = "xyz"[int(np.argmax(low >= high))]
        raise InputError("", "geofence", f"{axis} must go from a smaller number to a larger one, in '{text}'")
    return Geofence(low, high)
