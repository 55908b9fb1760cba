"""Estimates: what a fit says of the vehicle's keys, each with an interval, and what it cannot say, with the reason."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hotlap.core.records import Floats
from hotlap.core.shown import Shown
from hotlap.identification.evidence import Evidence
from hotlap.identification.fit import NORMAL, Fit, numbers_of
from hotlap.identification.manoeuvre import WORDS
from hotlap.identification.model import Numbers, thrust_map
from hotlap.identification.unknowns import AXES
from hotlap.race.quadrotor import Quadrotor

STEP = 1e-5  # of derivatives
MOST = {"log": math.log(1.25), "factor": math.log(2.0), "s": 0.01, "1/s": 0.2, "": 0.5, "N s^2/m^2": math.inf, "N^0.5 s/m": math.inf}
PARTS = {"integral": "factor of i, roll and pitch", "integral_z": "factor of i, yaw", "damping": "factor of d"}
TURNS = {"x": "roll", "y": "pitch", "z": "yaw"}


@dataclass(frozen=True, repr=False)
class Estimate(Shown):
    """One number of the vehicle.

    Attributes:
        name: in words.
        key: of the quadrotor's file that it goes to; "" where there is none.
        unit: of it.
        value: most likely one.
        low, high: 95 % interval.
        former: what the base says; NaN where it says nothing.
        reason: why the log cannot tell it; "" where it can.
        manoeuvre: which would tell it, in words for a pilot.
    """

    name: str
    key: str
    unit: str
    value: float
    low: float
    high: float
    former: float
    reason: str = ""
    manoeuvre: str = ""

    @property
    def told(self) -> bool:
        """Whether the log tells it."""
        return not self.reason

    def dump(self) -> dict[str, Any]:
        """As in `--json`."""
        return {**vars(self), "told": self.told}


@dataclass(frozen=True)
class _Asked:
    """A number to be estimated: what it is made of, and the unknown by which it is judged."""

    name: str
    key: str
    unit: str
    of: Callable[[Numbers], float]
    former: float
    is_log: bool = False
    most: float = math.inf
    why: Callable[[Sequence[Evidence]], tuple[str, str]] = lambda _: ("its interval is too wide", "")


def estimates_of(fit: Fit, base: Quadrotor, evidence: Sequence[Evidence], *, thrust_known: bool) -> tuple[Estimate, ...]:
    """All that a fit says.

    Args:
        fit: of all logs.
        base: the vehicle that was believed to be.
        evidence: of the logs.
        thrust_known: whether the base's thrust is right, and its mass is to be found; else the other way round.
    """
    present = {one.name for one in fit.unknowns}
    return tuple(_estimate(one, fit, evidence) for one in _asked(base, present, thrust_known=thrust_known))


def _estimate(asked: _Asked, fit: Fit, evidence: Sequence[Evidence]) -> Estimate:
    value, slope = asked.of(fit.numbers), np.empty(len(fit.theta))

    def counted(number: float) -> float:
        return math.log(max(number, 1e-9)) if asked.is_log else number

    for k in range(len(slope)):
        moved = fit.theta.copy()
        moved[k] += STEP
        slope[k] = (counted(asked.of(numbers_of(fit.unknowns, moved))) - counted(value)) / STEP
    half = NORMAL * math.sqrt(max(float(slope @ fit.covariance @ slope), 0.0))
    low, high = (counted(value) - half, counted(value) + half)
    if asked.is_log:
        low, high = math.exp(low), math.exp(min(high, 50.0))
    reason, manoeuvre = asked.why(evidence) if half > asked.most else ("", "")
    return Estimate(asked.name, asked.key, asked.unit, value, low, high, asked.former, reason, manoeuvre)


def _asked(base: Quadrotor, present: set[str], *, thrust_known: bool) -> list[_Asked]:
    """What can be estimated with these unknowns."""
    weight, most = base.gravity, base.rotor_count * base.rotor_thrust[1]
    if thrust_known:
        found = [_Asked("mass", "mass", "kg", lambda n: most / n["full"], base.mass, True, MOST["log"], _why_thrust)]
    else:
        share, former = base.mass / base.rotor_count, base.rotor_thrust[1]
        found = [_Asked("thrust of a rotor", "rotor_thrust", "N", lambda n: n["full"] * share, former, True, MOST["log"], _why_thrust)]
    found.append(_Asked("full thrust per mass", "", "m/s^2", lambda n: n["full"], base.max_acceleration, True, MOST["log"], _why_thrust))
    found.append(_Asked("hover throttle", "", "", lambda n: hover_throttle(n, weight), math.nan, True, MOST["log"], _why_thrust))
    if "curvature" in present:
        found.append(_Asked("curvature of thrust", "", "", lambda n: n["curvature"], math.nan, False, MOST[""], _why_thrust))
    if "battery" in present:
        found.append(_Asked("power of voltage", "", "", lambda n: n["battery"], math.nan, False, MOST[""], _why_battery))
    up, down = base.motor_time
    for name, former, sign in (("up", up, -0.5), ("down", down, 0.5)):
        of = lambda n, s=sign: n["lag"] * n["lag_ratio"] ** s  # noqa: E731
        found.append(_Asked(f"motor lag {name}", "motor_time", "s", of, former, True, MOST["log"], _why_lag))
    found += [_gain(base, k) for k in range(3) if f"gain_{AXES[k]}" in present]
    for name, words in PARTS.items():
        if name in present:
            of = lambda n, one=name: n[one]  # noqa: E731
            found.append(_Asked(words, f"rate_loop.{name}", "", of, 1.0, True, MOST["factor"]))
    found.append(_Asked("dead time", "delay", "s", lambda n: n["delay"], base.delay, False, MOST["s"], _why_delay))
    return found + _drags(base, present)


def _gain(base: Quadrotor, k: int) -> _Asked:
    """Of a proportional rate loop its gain, of a PID its proportional one, with which the others go."""
    axis, name = AXES[k], f"gain_{AXES[k]}"
    why = lambda evidence: _why_gain(evidence, k)  # noqa: E731
    if base.rate_loop is None:
        return _Asked(f"rate gain {TURNS[axis]}", "rate_gain", "1/s", lambda n: n[name], base.rate_gain[k], True, MOST["log"], why)
    p, share = base.rate_loop.p[k], base.rate_loop.p[k] / base.rate_gain[k]
    return _Asked(f"rate loop {TURNS[axis]}", "rate_loop.p", "s/rad", lambda n: n[name] * share, p, True, MOST["log"], why)


def _drags(base: Quadrotor, present: set[str]) -> list[_Asked]:
    """Drag along each axis, and that of the rotors."""
    if not any(name.startswith("drag") for name in present):
        nothing = lambda _: 0.0  # noqa: E731
        return [_Asked("drag", "", "1/s", nothing, math.nan, most=-1.0, why=lambda _: ("no velocity and attitude are logged", ""))]
    found = []
    if "rotor_drag" in present:
        of = lambda n: n["rotor_drag"]  # noqa: E731
        found.append(
            _Asked("rotor drag", "rotor_drag", "N^0.5 s/m", of, base.rotor_drag, most=max(base.rotor_drag, 0.01), why=_why_drag(0))
        )
    for k, axis in enumerate(AXES):
        if f"drag_{axis}" in present:
            of = lambda n, name=f"drag_{axis}": n[name]  # noqa: E731
            found.append(_Asked(f"drag {axis}", "drag", "1/s", of, base.drag[k], most=MOST["1/s"], why=_why_drag(k)))
        if f"body_drag_{axis}" in present:
            of = lambda n, name=f"body_drag_{axis}": n[name]  # noqa: E731
            found.append(_Asked(f"body drag {axis}", "body_drag", "N s^2/m^2", of, base.body_drag[k], why=_why_drag(k)))
    return found


def hover_throttle(numbers: Numbers, gravity: float) -> float:
    """The throttle that carries the weight, at the reference voltage."""
    c, share = numbers.get("curvature", 0.0), gravity / numbers["full"]
    if abs(c) < 1e-6:
        return share
    root = (1 - c) ** 2 + 4 * c * share
    return (math.sqrt(max(root, 0.0)) - (1 - c)) / (2 * c)


def thrust_at(numbers: Numbers, throttle: float) -> float:
    """Thrust per mass [m/s^2] at a throttle and the reference voltage."""
    return float(thrust_map(numbers, np.array([throttle]))[0])


def _spread(rows: Sequence[Floats]) -> tuple[float, float]:
    """Where all but the outermost values lie."""
    low, high = np.percentile(np.concatenate(rows), (1, 99))
    return float(low), float(high)


def _why_thrust(evidence: Sequence[Evidence]) -> tuple[str, str]:
    throttles = [one.flown(one.thrust_command)[:, 0] for one in evidence if one.thrust_command is not None]
    if not throttles:
        return "no thrust command is logged", ""
    if all(one.output is None for one in evidence):
        return "neither an accelerometer nor velocity with attitude is logged", ""
    low, high = _spread(throttles)
    return f"the throttle was from {low:.2f} to {high:.2f} only", WORDS["thrust"]


def _why_battery(evidence: Sequence[Evidence]) -> tuple[str, str]:
    low, high = _spread([one.flown(one.thrust_command)[:, 1] for one in evidence if one.thrust_command is not None])
    return (
        f"the battery was from {low:.2f} to {high:.2f} V only",
        WORDS["battery"],
    )


def _why_lag(evidence: Sequence[Evidence]) -> tuple[str, str]:
    reason, _ = _why_thrust(evidence)
    return reason if "logged" in reason else "no quick thrust steps and turns", WORDS["thrust"]


def _why_gain(evidence: Sequence[Evidence], k: int) -> tuple[str, str]:
    turn = TURNS[AXES[k]]
    moved = max(float(one.flown(one.rate_command)[:, k].std()) for one in evidence)
    return f"{turn} was hardly asked to turn ({moved:.2g} rad/s rms)", WORDS[turn]


def _why_delay(evidence: Sequence[Evidence]) -> tuple[str, str]:
    return _why_gain(evidence, 0)[0], WORDS["roll"]


def _why_drag(k: int) -> Callable[[Sequence[Evidence]], tuple[str, str]]:
    def why(evidence: Sequence[Evidence]) -> tuple[str, str]:
        speed = max(float(np.percentile(np.abs(one.air[:, k]), 99)) for one in evidence if one.air is not None)
        return f"no more than {speed:.1f} m/s along body {AXES[k]}", WORDS["straights"] if k < 2 else WORDS["thrust"]

    return why


def by_key(estimates: Sequence[Estimate]) -> Mapping[str, list[Estimate]]:
    """Estimates that go to one key of the file."""
    found = dict[str, list[Estimate]]()
    for one in estimates:
        if one.key:
            found.setdefault(one.key, []).append(one)
    return found
