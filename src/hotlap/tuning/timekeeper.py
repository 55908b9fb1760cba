"""Timekeeper: ends a search in time for its result to be chosen and validated."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters
from hotlap.core.records import Scores
from hotlap.tuning.loop import Tuning
from hotlap.tuning.objective import Flies

SELECTING = 0.25  # of the time, at most, for choosing the result
WORTH = 0.1  # of the time, at least, that a search must have left to go on


class Timekeeper:
    """Attends a run whose wall time is counted, and flies for it, to know how long flights take beside the thoughts of its tuner.

    Args:
        tuning: the run; where its settings have no minutes, nothing is done.
        objective: what flies.
        spent: [s] on it before.
        clock: [s]
    """

    def __init__(self, tuning: Tuning, objective: Flies, spent: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._tuning, self._objective = tuning, objective
        self._clock, self._begun, self._spent = clock, clock(), spent
        self._flights, self._flying, self._passes = 0, 0.0, 0
        self._seconds = 60 * tuning.settings.minutes
        if self._seconds and self.left < WORTH * self._seconds and tuning.best is not None and not tuning.searched:
            tuning.end_search(tuning.settings.selection // 4)
        self._over = tuning.searched

    @property
    def left(self) -> float:
        """[s] until the time is over."""
        return self._seconds - self._spent - (self._clock() - self._begun)

    def fly(self, parameters: Parameters, seeds: NDArray[np.int64]) -> Scores:
        """Fly parameters, shape (B, S, K), with the noise of seeds, shape (B,), and count the time."""
        begun = self._clock()
        scores = self._objective.fly(parameters, seeds)
        self._flights, self._flying = self._flights + len(seeds), self._flying + self._clock() - begun
        return scores

    def attend(self) -> None:
        """After each batch: end the search where one more would take what is needed to choose and to validate."""
        self._passes += 1
        if not self._seconds or self._over:
            return
        tuning, each = self._tuning, self._flying / max(self._flights, 1)
        selecting = min(tuning.settings.selection, int(SELECTING * self._seconds / max(each, 1e-9)))
        one_more = (self._clock() - self._begun) / self._passes
        if tuning.searched:
            tuning.limit_selection(selecting)
        elif self.left < one_more + each * (selecting + tuning.settings.validation):
            tuning.end_search(selecting)
        self._over = tuning.searched
