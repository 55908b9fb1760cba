"""Guard: what stops a real flight; it looks at every state before a command is computed from it."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from hotlap.core.errors import HotlapError
from hotlap.core.records import Floats
from hotlap.real_flight.geofence import Geofence
from hotlap.real_flight.link import Seen

STALE = 0.25  # s: the oldest state that is flown with; a controller predicts no further
LOOK_AHEAD = 0.1  # s beyond its age, over which a state is carried on before it is compared with the geofence
JUMP = 1.0  # m by which a position may differ from that which those before lead to, ...
REMEMBERED = 0.25  # ... s before it; so a position that stands still while the drone flies is found, too
MOVING = [0, 1, 2, 7, 8, 9]  # position and velocity in a state
STRAY = 3.0  # m from the reference, where nothing is said
LEFT = 0.2  # m from where it was armed: it flies
FROZEN = 0.5  # s over which a drone in the air may have the very same position and velocity; no sensor is so quiet
LONGEST_STEP = 0.5  # s from one state to the next at most; nothing was stale, so more is a clock that has leapt


class Reason(StrEnum):
    """Why a flight was stopped."""

    LINK = "the link was lost"
    STALE = "the state is too old"
    NUMBERS = "the state is not a number"
    COMMAND = "the command is not a number"
    JUMP = "the position has jumped"
    FROZEN = "the state no longer changes"
    TIME = "the vehicle's time has leapt"
    FENCE = "it reached the geofence"
    STRAYED = "it strayed from the reference"
    TAKEN_OVER = "it no longer follows hotlap: a pilot or the autopilot has taken over"
    DISARMED = "the motors were stopped"
    REFUSED = "the vehicle refused"
    NOT_LIFTED = "it did not lift off"
    UNSTEADY = "it did not become steady at the start"
    THRUST = "the thrust is not that of the file"
    INTERRUPTED = "it was interrupted"
    FAULT = "hotlap failed"


class Halt(HotlapError):  # noqa: N818  it stops a flight, which is no error
    """A flight has to be stopped now.

    Args:
        reason: why.
        detail: figures, for people.
    """

    def __init__(self, reason: Reason, detail: str = "") -> None:
        self.reason, self.detail = reason, detail
        super().__init__(f"{reason}{f': {detail}' if detail else ''}")


@dataclass
class Guard:
    """Compares states with limits.

    Attributes:
        geofence: the box.
        farthest: [m] from the reference at most; from which it is looked at when there is one.
        engaged, armed: whether it has been so, and has to stay so.
        flies: whether it has left the ground, as it says itself or as it has moved.
        last: the state before.
    """

    geofence: Geofence
    farthest: float
    engaged: bool = False
    armed: bool = False
    flies: bool = False
    last: Seen | None = None
    _led: deque[tuple[float, Floats]] = field(default_factory=deque)  # times, and positions less those to which velocities led
    _way: Floats = field(default_factory=lambda: np.zeros(3))  # m to which velocities led
    _met: Floats = field(default_factory=lambda: np.zeros(3))  # m, where it was armed
    _changed: float = 0.0  # s at which position and velocity were others

    def check(self, seen: Seen) -> None:
        """Look at a state (race).

        Raises:
            Halt: a limit is passed.
        """
        if self.engaged and not seen.engaged:
            raise Halt(Reason.TAKEN_OVER)  # first: whatever else is wrong, it is the pilot's now
        if self.armed and not seen.armed:
            raise Halt(Reason.DISARMED)
        check_usable(seen)
        if self.armed:
            self._check_motion(seen)
            ahead = seen.state[:3] + (max(seen.age, 0.0) + LOOK_AHEAD) * seen.state[7:10]
            if self.geofence.outside(ahead):
                raise Halt(Reason.FENCE, f"at ({_place(seen.state[:3])}) m with {np.linalg.norm(seen.state[7:10]):.1f} m/s")
        self.last = seen

    def check_distance(self, seen: Seen, reference: Floats) -> None:
        """Look at how far it is from the reference, shape (13,), at the time of the state.

        Raises:
            Halt: too far.
        """
        distance = float(np.linalg.norm(seen.state[:3] + max(seen.age, 0.0) * seen.state[7:10] - reference[:3]))
        if distance > self.farthest:
            raise Halt(Reason.STRAYED, f"{distance:.1f} m from it at ({_place(seen.state[:3])}) m")

    def _check_motion(self, seen: Seen) -> None:
        """Look at whether positions go where velocities lead, and go on."""
        before = self.last
        if before is None or seen.time <= before.time:
            return
        step = seen.time - before.time
        if step > LONGEST_STEP:
            raise Halt(Reason.TIME, f"by {step:.2f} s")
        if seen.resets != before.resets:
            raise Halt(Reason.JUMP, "the autopilot has reset its estimate")
        if not self._led:
            self._led.append((before.time, before.state[:3]))
            self._met, self._changed = before.state[:3], before.time
        self._way = self._way + step * (before.state[7:10] + seen.state[7:10]) / 2
        self._led.append((seen.time, seen.state[:3] - self._way))
        while seen.time - self._led[0][0] > REMEMBERED and len(self._led) > 2:
            self._led.popleft()
        jump = float(np.linalg.norm(self._led[-1][1] - self._led[0][1]))
        if jump > JUMP:
            raise Halt(Reason.JUMP, f"by {jump:.1f} m")
        self.flies = self.flies or seen.on_ground is False or float(np.linalg.norm(seen.state[:3] - self._met)) > LEFT
        if not self.flies or (seen.state[MOVING] != before.state[MOVING]).any():
            self._changed = seen.time
        elif seen.time - self._changed > FROZEN:
            raise Halt(Reason.FROZEN, f"for {seen.time - self._changed:.2f} s")


def check_usable(seen: Seen) -> None:
    """Look at whether a state can be flown with, wherever it is.

    Raises:
        Halt: it is not of numbers, or too old.
    """
    if not np.isfinite(seen.state).all() or not 0.9 < float(np.linalg.norm(seen.state[3:7])) < 1.1:
        raise Halt(Reason.NUMBERS)
    if seen.age > STALE:
        raise Halt(Reason.STALE, f"{seen.age:.2f} s")


def _place(point: Floats) -> str:
    return ", ".join(f"{value:.1f}" for value in point)
