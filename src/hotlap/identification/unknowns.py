"""Unknowns: what a fit looks for, how each is counted, and what is believed before the log is seen."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hotlap.core.records import Floats
from hotlap.identification.evidence import Evidence
from hotlap.race.quadrotor import Quadrotor

AXES = ("x", "y", "z")
BATTERY_POWER = 2.0  # of the voltage, with which thrust goes where nothing regulates the motors
LEAST_LAG = 1e-3  # s
SIMULATED = (
    "full",
    "curvature",
    "battery",
    "lag",
    "lag_ratio",
    "gain_x",
    "gain_y",
    "gain_z",
    "integral",
    "integral_z",
    "damping",
    "delay",
)  # a change needs a replay


@dataclass(frozen=True)
class Unknown:
    """One number that a fit looks for.

    Attributes:
        name: of it.
        start: with which the fit begins; a logarithm where `is_log`.
        belief: standard deviation around the start that is believed before; weak, so that only what a log says nothing about feels it.
        is_log: whether the logarithm is fitted.
    """

    name: str
    start: float
    belief: float
    is_log: bool = False


def unknowns_of(
    base: Quadrotor, evidence: Sequence[Evidence], quadratic: Sequence[str] = (), *, straight: bool = False, loop_known: bool = False
) -> tuple[Unknown, ...]:
    """What is looked for in logs.

    Args:
        base: the vehicle that it is believed to be.
        evidence: of its logs.
        quadratic: axes along which drag grows with the square of the speed, besides.
        straight: whether thrust is known to be proportional to its command.
        loop_known: whether the base's rate loop is right.
    """
    found = [Unknown("full", math.log(base.max_acceleration), 2.0, is_log=True)]
    if not straight:
        found.append(Unknown("curvature", 0.3, 1.0))
    if any(one.has_battery for one in evidence):
        found.append(Unknown("battery", BATTERY_POWER, 1.0))
    up, down = (max(time, LEAST_LAG) for time in base.motor_time)
    found.append(Unknown("lag", math.log(up * down) / 2, 1.5, is_log=True))
    found.append(Unknown("lag_ratio", math.log(down / up), 0.7, is_log=True))
    found += [] if loop_known else _gains(base)
    found.append(Unknown("delay", base.delay, 0.2))
    if any(one.output is not None and one.air is not None for one in evidence):
        found += _drags(base, quadratic)
    for k, one in enumerate(evidence):
        found += [Unknown(f"gyroscope_{axis}.{k}", 0.0, 0.5) for axis in AXES]
        if one.force is not None:
            found += [Unknown(f"accelerometer_{axis}.{k}", 0.0, 0.1) for axis in AXES]
    return tuple(found)


def _gains(base: Quadrotor) -> list[Unknown]:
    """Of the rate loop: the gain of each axis, and factors of a PID's other parts."""
    found = [Unknown(f"gain_{axis}", math.log(gain), 2.0, is_log=True) for axis, gain in zip(AXES, base.rate_gain, strict=True)]
    if base.rate_loop is not None:
        i, d = base.rate_loop.i, base.rate_loop.d
        shown = {"integral": any(i[:2]), "integral_z": i[2] > 0, "damping": any(d)}
        found += [Unknown(name, 0.0, 0.7, is_log=True) for name, there in shown.items() if there]
    return found


def _drags(base: Quadrotor, quadratic: Sequence[str]) -> list[Unknown]:
    """Drag in the form that the base has: with the rotors' speed, or by itself."""
    with_rotors = base.rotor_drag > 0
    found = [Unknown("rotor_drag", base.rotor_drag, 1.0)] if with_rotors else []
    axes = AXES[2:] if with_rotors else AXES
    found += [Unknown(f"drag_{axis}", base.drag[AXES.index(axis)], 2.0) for axis in axes]
    return found + [Unknown(f"body_drag_{axis}", 0.0, base.mass) for axis in quadratic]


def moved(unknowns: Sequence[Unknown], to: Mapping[str, float]) -> tuple[Unknown, ...]:
    """The same with other starts."""
    return tuple(replace(one, start=to.get(one.name, one.start)) for one in unknowns)


def starts(unknowns: Sequence[Unknown]) -> Floats:
    """Where a fit begins, shape (P,)."""
    return np.array([one.start for one in unknowns])
