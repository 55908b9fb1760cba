"""The commands that a controller has given, and for how long each: control steps of a vehicle are not exactly a period apart."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.flight.fly import acting
from hotlap.flight.job import Settings

Floats = NDArray[np.float64]

EVEN = 1e-6  # of a period: as good as its end
FOR_EVER = 100.0  # s that the oldest command is taken to have acted


class CommandLog:
    """Lays the commands out as the compiled control step expects them: what acted in each whole period before now, the newest first.

    The last two rows of the history are room for the thrust that acted while the vehicle moved from one measured state to the next.

    Args:
        history: shape (H, 4), memory of the control loop.
        period: [s] of the control loop.
    """

    def __init__(self, history: Floats, period: float) -> None:
        self._history, self._period = history, period
        self.reset()

    def reset(self) -> None:
        """Take the history as it stands, a period for each command."""
        self._commands, self._spans = self._history[:-2].copy(), np.full(len(self._history) - 2, self._period)

    def rounded(self, elapsed: float) -> float:
        """A time that has passed [s], the period itself where that is meant."""
        return self._period if abs(elapsed - self._period) < EVEN * self._period else elapsed

    def lay_out(self, settings: Settings, elapsed: float, dead_time: float, observed: float) -> Settings:
        """Write the history for a control step.

        Args:
            settings: of the step.
            elapsed: [s] since the step before: the newest command has acted for that long.
            dead_time: [s] before now at which the commands were given that acted until the state was measured.
            observed: [s] between that state and the one before.

        Returns:
            The settings that tell the observer where the thrust is that was commanded meanwhile.
        """
        self._spans[0] = elapsed
        if observed == self._period and (self._spans == self._period).all():
            self._history[:-2] = self._commands
            self._history[-2:] = self._commands[-1]
            return acting(settings, dead_time)
        begins = self._period * np.arange(len(self._commands))
        self._history[:-2] = self._means(begins, self._period)
        self._history[-2:] = self._means(np.array([dead_time]), observed)
        return settings._replace(acted_periods=len(self._history) - 2, acted_rest=0.0)

    def keep(self) -> None:
        """Take up the command that the control step has put at the head of the history."""
        self._commands, self._spans = np.roll(self._commands, 1, axis=0), np.roll(self._spans, 1)
        self._commands[0], self._spans[0] = self._history[0], self._period

    def _means(self, begins: NDArray[np.floating[Any]], length: float) -> Floats:
        """Mean commands over windows that lie so long [s] before now, shape (n, 4)."""
        ends = np.cumsum(self._spans)
        starts = np.concatenate([[0.0], ends[:-1]])
        ends[-1] += FOR_EVER
        shares = np.minimum(begins[:, None] + length, ends) - np.maximum(begins[:, None], starts)
        return np.asarray(np.maximum(shares, 0.0) @ self._commands / length, dtype=np.float64)
