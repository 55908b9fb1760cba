"""Plausibility: whether the numbers of a log can be in the units that they are said to be in."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from hotlap.core.errors import InputError
from hotlap.core.records import Floats
from hotlap.logs.flight_log import FlightLog

LONGEST = 24 * 3600.0  # s
FASTEST_SAMPLING = 50_000.0  # Hz


def check_units(log: FlightLog) -> None:
    """Refuse a log whose numbers no drone can have.

    Raises:
        InputError: says which signal, and which unit it seems to be in.
    """
    for name, signal in log.signals.items():
        if signal.rate > FASTEST_SAMPLING:
            raise InputError(log.name, name, f"has {signal.rate:.0f} samples a second: are the times in seconds?")
        told = CHECKS[name](signal.values) if name in CHECKS else ""
        if told:
            raise InputError(log.name, name, told)
    if log.duration > LONGEST:
        raise InputError(log.name, "time", f"spans {log.duration:.3g} s: are the times in seconds, and not in ms or us?")


def _largest(values: Floats) -> float:
    """Size that one sample in a hundred exceeds."""
    return float(np.quantile(np.abs(values).max(axis=1), 0.99))


def _position(values: Floats) -> str:
    most = float(np.ptp(values, axis=0).max())
    return f"spans {most:.3g} m: is it in metres?" if most > 20_000 else ""


def _velocity(values: Floats) -> str:
    most = _largest(values)
    return f"is up to {most:.3g} m/s: is it in m/s?" if most > 200 else ""


def _attitude(values: Floats) -> str:
    size = float(np.median(np.linalg.norm(values, axis=1)))
    return f"has quaternions of length {size:.3g}, not 1" if abs(size - 1) > 0.05 else ""


def _rates(values: Floats) -> str:
    most = _largest(values)
    return f"is up to {most:.3g} rad/s: is it in deg/s?" if most > 40 else ""


def _acceleration(values: Floats) -> str:
    size = float(np.median(np.linalg.norm(values, axis=1)))
    if size < 3:
        return f"is {size:.3g} m/s^2 most of the time, and hovering is 9.81: is it in g, or without gravity?"
    return f"is {size:.3g} m/s^2 most of the time: is it in m/s^2?" if size > 120 else ""


def _share(values: Floats) -> str:
    least, most = float(values.min()), float(values.max())
    return f"is from {least:.3g} to {most:.3g}, and must be from 0 to 1" if most > 1.2 or least < -0.5 else ""


def _battery(values: Floats) -> str:
    usual = float(np.median(values))
    return f"is {usual:.5g} V: is it in mV?" if usual > 200 else ""


CHECKS: Mapping[str, Callable[[Floats], str]] = {
    "position": _position,
    "velocity": _velocity,
    "attitude": _attitude,
    "rates": _rates,
    "rate_command": _rates,
    "acceleration": _acceleration,
    "thrust_command": _share,
    "motor_command": _share,
    "battery": _battery,
}
