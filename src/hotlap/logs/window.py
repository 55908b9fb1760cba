"""Window: the part of a log that counts, by its own clock."""

from __future__ import annotations

import math
from dataclasses import replace

from hotlap.core.errors import InputError
from hotlap.logs.flight_log import FlightLog, Signal

Window = tuple[float | None, float | None]
"""[s] of the log's clock from which on and up to which it counts; None: from its beginning, up to its end."""

FROM, TO = "from", "to"


def check_window(window: Window | None) -> None:
    """Refuse what is no window.

    Raises:
        InputError: it is no pair of numbers, or ends before it begins.
    """
    if window is None:
        return
    if not isinstance(window, tuple | list) or len(window) != 2:
        raise InputError("", "window", "must be (from, to) in seconds of the log's clock; None for a side that is open")
    for key, value in zip((FROM, TO), window, strict=True):
        if value is not None and not (isinstance(value, float | int) and math.isfinite(value)):
            raise InputError("", key, f"must be a number of seconds, not {value!r}")
    begin, end = window
    if begin is not None and end is not None and begin >= end:
        raise InputError("", TO, f"is {end:g} s, which is not after {begin:g} s")


def cut(log: FlightLog, window: Window | None) -> FlightLog:
    """A log without what lies outside of a window, with a note that says so.

    Args:
        log: all of it.
        window: None: the same log.

    Raises:
        InputError: the log has nothing within it.
    """
    check_window(window)
    if window is None or window == (None, None):
        return log
    begin, end = (-math.inf if window[0] is None else window[0]), (math.inf if window[1] is None else window[1])
    first, last = log.start, log.start + log.duration
    signals = dict[str, Signal]()
    for name, signal in log.signals.items():
        inside = (signal.times >= begin) & (signal.times <= end)
        if inside.any():
            signals[name] = Signal(signal.times[inside], signal.values[inside])
    if not signals:
        raise InputError("", FROM if begin > last else TO, f"leaves nothing of {log.name}, which is from {first:.2f} to {last:.2f} s")
    said = f"from {max(begin, first):.2f} to {min(end, last):.2f} s of a log from {first:.2f} to {last:.2f} s, as asked for"
    return replace(log, signals=signals, notes=(*log.notes, said))
