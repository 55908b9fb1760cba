"""Recording: gathers the signals of a log that is being read, and sees that each is in order."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hotlap.core.errors import InputError
from hotlap.core.records import Floats
from hotlap.logs.flight_log import COLUMNS, FlightLog, Signal
from hotlap.reference.attitude import continuous

DISORDER = 0.01  # share of the samples that may stand behind a later one: more are no accident
MEASURED = ("battery", "current", "motor_speed")  # by sensors that a drone may be without: what they would tell is often logged as NaN
LARGEST = 1e12  # of a value, in its unit: more is no measurement, and its square no number
LARGEST_TIME = 1e20  # s; of an epoch in ns, which is asked about later, less
EPOCH = 1e6  # s: clocks that are further on count from another year, and lose digits


class Recording:
    """Signals as they are found; the first of a name counts.

    Args:
        name: of the file.
        kind: which program wrote it, in words.
    """

    def __init__(self, name: str, kind: str) -> None:
        self.name, self.kind = name, kind
        self.facts: dict[str, Any] = {}
        self._signals: dict[str, Signal] = {}
        self._notes: list[str] = []

    def __contains__(self, signal: str) -> bool:
        """Whether there is a signal of this name already."""
        return signal in self._signals

    def note(self, text: str) -> None:
        """Say what was assumed, once."""
        if text not in self._notes:
            self._notes.append(text)

    def fail(self, key: str, reason: str) -> InputError:
        """What is wrong with the file."""
        return InputError(self.name, key, reason)

    def add(self, signal: str, times: ArrayLike, values: ArrayLike, said: str = "") -> None:
        """Take up a signal; nothing where there is one already, or no sample.

        Args:
            signal: of `COLUMNS`.
            times: shape (N,) [s].
            values: shape (N,) or (N, D), in units and frame of `COLUMNS`.
            said: what was assumed about it.

        Raises:
            InputError: it is out of order, has no finite value, or has another number of columns.
        """
        moments, rows = np.asarray(times, dtype=np.float64), np.asarray(values, dtype=np.float64)
        rows = rows[:, None] if rows.ndim == 1 else rows
        if signal in self._signals or not rows.size:
            return
        if COLUMNS[signal] not in {0, rows.shape[1]}:
            raise self.fail(signal, f"has {rows.shape[1]} columns, not {COLUMNS[signal]}")
        if signal in MEASURED and not np.isfinite(rows).all(axis=1).any():
            self.note(f"{signal}: logged, but never measured")
            return
        moments, rows = self._finite(signal, moments, rows)
        if signal == "attitude":
            moments, rows = self._turned(moments, rows)
        moments, rows = self._ordered(signal, moments, rows)
        if signal == "attitude":  # q and -q are one attitude: without jumps it can be drawn between samples
            rows = continuous(rows)
        self._signals[signal] = Signal(moments, rows)
        if said:
            self.note(said)

    def finish(self) -> FlightLog:
        """The log.

        Raises:
            InputError: there is no signal in it.
        """
        if not self._signals:
            raise self.fail("", f"is {self.kind} without any signal that hotlap knows: {', '.join(COLUMNS)}")
        first = min(float(signal.times[0]) for signal in self._signals.values())
        signals: Mapping[str, Signal] = self._signals
        if abs(first) > EPOCH:
            signals = {name: Signal(signal.times - first, signal.values) for name, signal in self._signals.items()}
            self.note(f"time 0 is {first:.6f} s of the log's clock")
        return FlightLog(self.name, self.kind, signals, self.facts, tuple(self._notes))

    def _finite(self, signal: str, moments: Floats, rows: Floats) -> tuple[Floats, Floats]:
        """Samples that are numbers."""
        good = (np.abs(moments) < LARGEST_TIME) & (np.abs(rows) < LARGEST).all(axis=1)
        lost = len(good) - int(good.sum())
        if lost == len(good):
            raise self.fail(signal, f"has no finite value in {len(good)} samples")
        if lost:
            self.note(f"{signal}: {lost} of {len(good)} samples are not finite and were left out")
        return moments[good], rows[good]

    def _turned(self, moments: Floats, rows: Floats) -> tuple[Floats, Floats]:
        """Attitudes that are some: a tracker that has lost a drone writes zeros."""
        good = np.linalg.norm(rows, axis=1) > 0
        lost = len(good) - int(good.sum())
        if lost == len(good):
            raise self.fail("attitude", f"has a quaternion of length 0 in all of {len(good)} samples")
        if lost:
            self.note(f"attitude: {lost} of {len(good)} samples are quaternions of length 0 and were left out")
        return moments[good], rows[good]

    def _ordered(self, signal: str, moments: Floats, rows: Floats) -> tuple[Floats, Floats]:
        """Samples in order, each time once."""
        behind = int((np.diff(moments) < 0).sum())
        if behind > max(1.0, DISORDER * len(moments)):
            raise self.fail(signal, f"times go back {behind} times in {len(moments)} samples: they must increase")
        order = np.argsort(moments, kind="stable")
        moments, rows = moments[order], rows[order]
        fresh = np.append(True, np.diff(moments) > 0)
        return np.ascontiguousarray(moments[fresh]), np.ascontiguousarray(rows[fresh])
