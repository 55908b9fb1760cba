"""Clocks: what time it is on the vehicle, and so how old a state is.

TIMESYNC asks: a question with our time is answered with the vehicle's beside it. Of the last answers the one that took least tells the
offset best, for whatever made the others late did so on one of the two ways. Without answers the state that came earliest counts as fresh.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable
from typing import Protocol

KEPT = 20  # answers
WITHIN = 1.0  # s: an offset that differs more from what states say is of another clock
FORGET = 10.0  # s after which how early a state came is forgotten


class VehicleClock(Protocol):
    """The vehicle's clock, as it can be told here."""

    def now(self) -> float:
        """[s] of the vehicle."""
        ...

    def ours(self) -> float:
        """[s] of our own clock, for questions; it is what `answered` compares with."""
        ...

    def stamped(self, stamp: float) -> None:
        """A state has come that was measured at a time [s] of the vehicle."""
        ...

    def told(self, stamp: float) -> None:
        """The vehicle has said its own time [s], just now."""
        ...

    def answered(self, asked: float, stamp: float) -> None:
        """The vehicle has answered its time [s] to a question of a time [s] of ours."""
        ...


class OffsetClock:
    """Our own clock, and an offset.

    Args:
        clock: ours [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._answers: deque[tuple[float, float]] = deque(maxlen=KEPT)  # (duration, offset)
        self._earliest, self._earliest_at = -math.inf, -math.inf

    @property
    def is_synchronised(self) -> bool:
        """Whether there are answers that can be of the clock that states have."""
        return bool(self._answers) and (math.isinf(self._earliest) or abs(min(self._answers)[1] - self._earliest) < WITHIN)

    def now(self) -> float:
        """Ours and the offset, which is no less than the earliest state shows; 0 before anything is known."""
        if self.is_synchronised:
            return self._clock() + max(min(self._answers)[1], self._earliest)
        return self._clock() + self._earliest if math.isfinite(self._earliest) else 0.0

    def ours(self) -> float:
        """Ours."""
        return self._clock()

    def stamped(self, stamp: float) -> None:
        """What comes earlier than all others tells the offset from one side."""
        now = self._clock()
        if stamp - now >= self._earliest or now - self._earliest_at > FORGET:
            self._earliest, self._earliest_at = stamp - now, now

    def told(self, stamp: float) -> None:
        """How long that took nobody knows."""

    def answered(self, asked: float, stamp: float) -> None:
        """In the middle between question and answer."""
        now = self._clock()
        if asked <= now:
            self._answers.append((now - asked, stamp - (asked + now) / 2))


class FollowedClock:
    """The latest time that the vehicle has said, for simulations that are not in real time."""

    def __init__(self) -> None:
        self._now = 0.0

    def now(self) -> float:
        """The latest."""
        return self._now

    def ours(self) -> float:
        """The same."""
        return self._now

    def stamped(self, stamp: float) -> None:
        """A state is from then, or from before."""
        self._now = max(self._now, stamp)

    def told(self, stamp: float) -> None:
        """Its own time."""
        self._now = max(self._now, stamp)

    def answered(self, asked: float, stamp: float) -> None:
        """Nothing that it has not told; and a question asked of its own clock says nothing."""
