"""Rates: how fast flights come in, in words."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

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
