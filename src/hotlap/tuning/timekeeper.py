"""Timekeeper: ends a search in time for its result to be chosen and validated."""

from __future__ import annotations

import time
from collections.abc import Callable

from hotlap.tuning.loop import Tuning

SELECTING = 0.25  # of the time, at most, for choosing the result
WORTH = 0.1  # of the time, at least, that a search must have left to go on


class Timekeeper:
    """Attends a run whose wall time is counted.

    Args:
        tuning: the run; where its settings have no minutes, nothing is done.
        spent: [s] on it before.
        clock: [s]
    """

    def __init__(self, tuning: Tuning, spent: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._tuning, self._clock, self._begun, self._spent = tuning, clock, clock(), spent
        self._first, self._seconds = _flown(tuning), 60 * tuning.settings.minutes
        if self._seconds and self.left < WORTH * self._seconds and tuning.best is not None and not tuning.searched:
            tuning.end_search(tuning.settings.selection // 4)

    @property
    def left(self) -> float:
        """[s] until the time is over."""
        return self._seconds - self._spent - (self._clock() - self._begun)

    def attend(self) -> None:
        """After each batch: end the search where what is left is needed to choose and to validate."""
        tuning = self._tuning
        flown = _flown(tuning) - self._first
        if not self._seconds or tuning.searched or not flown:
            return
        each, settings = (self._clock() - self._begun) / flown, tuning.settings  # thinking included, which is to spare
        selecting = min(settings.selection, int(SELECTING * self._seconds / max(each, 1e-9)))
        if self.left < each * (selecting + settings.validation):
            tuning.end_search(selecting)


def _flown(tuning: Tuning) -> int:
    """All flights."""
    return tuning.flights + tuning.selection_flights + tuning.validation_flights
