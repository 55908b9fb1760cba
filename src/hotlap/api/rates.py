"""Rates: how fast flights come in, in words."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from hotlap.api.wording import duration

if TYPE_CHECKING:
    from hotlap.analysis.comparison import Run


class Flown:
    """Counts the flights of runs.

    Args:
        clock: [s]
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._flights, self._rate = 0, Rate(0, clock)

    def __call__(self, run: Run) -> str:
        """Count a run; in few words, what it was and how fast flights are."""
        self._flights += run.flights + run.validation
        return f"{run.race} by {run.tuner}, {self._rate(self._flights)}"


class Rate:
    """Flights per second since it was made.

    Args:
        flown: flights so far.
        clock: [s]
    """

    def __init__(self, flown: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._flown, self._clock, self._start = flown, clock, clock()

    def __call__(self, flights: int) -> str:
        """For people, as of now."""
        elapsed = self._clock() - self._start
        return f"{(flights - self._flown) / elapsed:.3g} flights/s" if elapsed > 0 else "- flights/s"


class Pace:
    """Flights that take seconds, counted one by one: how fast they come, and how long the rest will take.

    The first one, which may have waited for its simulator to be opened, counts only until there is another.

    Args:
        clock: [s]

    Attributes:
        flown: flights so far.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.flown, self._clock, self._start = 0, clock, clock()
        self._first = self._last = self._start

    def count(self) -> None:
        """A flight has ended now."""
        self.flown, self._last = self.flown + 1, self._clock()
        if self.flown == 1:
            self._first = self._last

    @property
    def speed(self) -> float:
        """[1/s]; 0 where nobody knows."""
        flights, elapsed = (self.flown - 1, self._last - self._first) if self.flown > 1 else (self.flown, self._last - self._start)
        return flights / elapsed if elapsed > 0 else 0.0

    def words(self, left: int, most: str = "") -> str:
        """For people.

        Args:
            left: flights that are still to be flown.
            most: what stands before the time that they take.
        """
        if not self.speed:
            return "- flights/s"
        return f"{self.speed:.3g} flights/s" + (f", {most}{duration(left / self.speed)} left" if left > 0 else "")
