"""Flight log: what was measured and commanded in one flight, each signal on the times at which it was taken."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hotlap.core.records import Floats
from hotlap.core.shown import Shown

COLUMNS: Mapping[str, int] = {  # of each signal that is known
    "position": 3,  # [m] world, z up
    "velocity": 3,  # [m/s] world
    "attitude": 4,  # quaternion w, x, y, z from the body (x forward, y left, z up) to the world
    "rates": 3,  # [rad/s] body
    "acceleration": 3,  # [m/s^2] specific force of the body, as an accelerometer feels it: hovering is (0, 0, 9.81)
    "rate_command": 3,  # [rad/s] body, as the rate loop was told
    "thrust_command": 1,  # 0 to 1, as the mixer was told
    "motor_command": 0,  # 0 to 1 of each motor; as many as there are
    "motor_speed": 0,  # [rad/s] of each motor
    "battery": 1,  # [V]
    "current": 1,  # [A]
}


GAP, USUAL = 0.25, 5.0  # s without a sample, and times the usual step, that are a gap


@dataclass(frozen=True, repr=False)
class Signal(Shown):
    """One signal.

    Attributes:
        times: shape (N,) [s], increasing.
        values: shape (N, D), finite.
    """

    times: Floats
    values: Floats

    @property
    def rate(self) -> float:
        """Samples a second; 0 for fewer than two."""
        return 0.0 if len(self.times) < 2 else float((len(self.times) - 1) / (self.times[-1] - self.times[0]))

    @property
    def step(self) -> float:
        """[s] usual time from sample to sample, gaps apart; infinite for fewer than two."""
        return float(np.median(np.diff(self.times))) if len(self.times) > 1 else math.inf

    def at(self, times: Floats) -> Floats:
        """Linear between samples; NaN before the first and behind the last.

        Args:
            times: shape (T,) [s].

        Returns:
            shape (T, D).
        """
        columns = [np.interp(times, self.times, column, left=np.nan, right=np.nan) for column in self.values.T]
        return np.column_stack(columns) if columns else np.empty((len(times), 0))

    def gaps(self, least: float = GAP) -> Floats:
        """Begin and end of each time without a sample that is longer than some, and than five usual steps, shape (G, 2) [s].

        Args:
            least: [s].
        """
        spans = np.diff(self.times)
        k = np.flatnonzero(spans > max(least, USUAL * self.step))
        return np.column_stack([self.times[k], self.times[k + 1]])


@dataclass(frozen=True, repr=False)
class FlightLog(Shown):
    """What is known of one flight.

    Attributes:
        name: of the file.
        kind: which program wrote it, in words.
        signals: by names of `COLUMNS`; those that were not logged are missing.
        facts: what the log says of the vehicle and its settings, such as rate loop gains, by the names that its program has for them.
        notes: what was assumed, a line each.
    """

    name: str
    kind: str
    signals: Mapping[str, Signal]
    facts: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def start(self) -> float:
        """[s] at which the first signal begins."""
        return min((float(signal.times[0]) for signal in self.signals.values()), default=0.0)

    @property
    def duration(self) -> float:
        """[s] until the last signal ends."""
        return max((float(signal.times[-1]) for signal in self.signals.values()), default=0.0) - self.start
