"""Shared time: the wall time of a search in which several plans are tuned one after the other, their planning and compiling included."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

LEAST = 0.5  # of its part, that the search of a plan has however long its planning took


class SharedTime:
    """Shares out some minutes among plans; where there are none, nothing is counted.

    Args:
        minutes: of all plans together; 0: time is not counted.
        parts: of them, of which a plan may take one.
        spent: [s] before.
        clock: [s]
    """

    def __init__(self, minutes: float, parts: int, spent: float = 0.0, clock: Callable[[], float] = time.monotonic) -> None:
        self._seconds, self._part = 60 * minutes, 60 * minutes / parts
        self._spent, self._planning, self._clock = spent, 0.0, clock

    @property
    def spent(self) -> float:
        """[s] so far."""
        return self._spent

    @property
    def left(self) -> float:
        """[s] until the time is over; negative after that."""
        return self._seconds - self._spent

    @property
    def enough(self) -> bool:
        """Whether one more plan can be made and tuned in what is left; the first one can."""
        return not self._seconds or not self._spent or self.left >= self._planning + LEAST * self._part

    def search(self, prepared: float) -> float:
        """Minutes for the search of a plan that took so many seconds to be made ready to fly; 0 where time is not counted."""
        return max(min(self._part - prepared, self.left), LEAST * self._part) / 60

    def take(self, seconds: float) -> None:
        """Count time that somebody else has measured."""
        self._spent += seconds

    @contextmanager
    def counted(self) -> Iterator[None]:
        """Count the time within, whatever ends it."""
        begun = self._clock()
        try:
            yield
        finally:
            self._spent += self._clock() - begun

    @contextmanager
    def planning(self) -> Iterator[None]:
        """Count the time within, and expect the next plan to take as long as the longest."""
        before = self._spent
        try:
            with self.counted():
                yield
        finally:
            self._planning = max(self._planning, self._spent - before)
