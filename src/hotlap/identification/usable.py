"""Usable: what of a log a fit can be made of; what it cannot do without is asked for, the rest is left out with a note."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.logs.flight_log import FlightLog, Signal

Mask = NDArray[np.bool_]

SHORTEST = 5.0  # s of a log, and of whatever is to tell something of it
COARSEST = 20.0  # samples a second below which a rate loop cannot be seen
SPARSEST = 5.0  # samples a second of forces and motion, below which they are not used
LEAST_VOLTS = 1.0  # V: less is no battery, but an input that nothing is connected to
NEEDED = {"rates": "no body rates: a gyroscope's log is needed", "rate_command": "no commanded body rates"}
TELLING = ("thrust_command", "acceleration", "velocity", "attitude")


def usable(log: FlightLog) -> tuple[Mapping[str, Signal], tuple[str, ...]]:
    """Signals that a fit can use, and notes of what was left out.

    Raises:
        InputError: the log lacks what no identification can do without, or cannot be right.
    """
    _check(log)
    signals, notes = dict(log.signals), list[str]()
    for name, good, what in (("battery", _has_volts, "without a voltage"), ("attitude", _turns, "of length 0")):
        if name in signals:
            kept = good(signals[name])
            if not kept.all():
                notes.append(f"{log.name}: {name}: {np.sum(~kept)} of {len(kept)} samples are {what} and were left out")
            signals[name] = Signal(signals[name].times[kept], signals[name].values[kept])
    needed = [signals[name] for name in NEEDED]
    start, end = max(float(one.times[0]) for one in needed), min(float(one.times[-1]) for one in needed)
    for name in (*TELLING, "battery"):
        reason = _useless(signals[name], start, end, rated=name in TELLING) if name in signals else ""
        if reason:
            del signals[name]
            notes.append(f"{log.name}: {name}: {reason}: it was left out")
    return signals, tuple(notes)


def _has_volts(battery: Signal) -> Mask:
    return np.asarray(battery.values[:, 0] >= LEAST_VOLTS)


def _turns(attitude: Signal) -> Mask:
    return np.asarray(np.linalg.norm(attitude.values, axis=1) > 0)


def _useless(signal: Signal, start: float, end: float, *, rated: bool) -> str:
    """Why a signal tells nothing between two times [s]; "" where it does."""
    if not len(signal.times):
        return "it has no sample"
    shared = min(end, signal.times[-1]) - max(start, signal.times[0])
    if shared < min(SHORTEST, end - start):
        return f"{max(shared, 0.0):.1f} s of it lie beside rates and commands"
    return f"{signal.rate:.2g} samples a second are too few" if rated and signal.rate < SPARSEST else ""


def _check(log: FlightLog) -> None:
    """Refuse a log that cannot be used."""
    for name, what in NEEDED.items():
        if name not in log.signals:
            raise InputError(log.name, name, f"is missing: {what}")
        signal = log.signals[name]
        if signal.values.shape[1] != 3:
            raise InputError(log.name, name, f"has {signal.values.shape[1]} axes, not 3")
        if len(signal.times) < 2 or signal.rate < COARSEST:
            raise InputError(log.name, name, f"has {signal.rate:.3g} samples a second; at least {COARSEST:g} are needed")
    for name, signal in log.signals.items():
        if not np.isfinite(signal.values).all() or (np.diff(signal.times) <= 0).any():
            raise InputError(log.name, name, "has values that are not finite, or times that do not increase")
