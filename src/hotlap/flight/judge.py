"""The judge: whether gates were passed, and how a flight ended (Eq. 6 of the paper, and the other rules).

It sees one flight at the ends of control periods, drawn as straight lines in between; worlds of all kinds call it.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.core.records import End
from hotlap.flight.numbers import INLINE
from hotlap.race.race import GateRule, JudgeSettings

CLOCK, CLOSEST, RELEASED = range(3)  # as compiled code knows the rules
_RULES = {GateRule.CLOCK: CLOCK, GateRule.CLOSEST: CLOSEST, GateRule.RELEASED: RELEASED}
FINISHED, MISSED, CRASHED = int(End.FINISHED), int(End.MISSED), int(End.CRASHED)
FLYING = -1


class Gates(NamedTuple):
    """The gates of a race, and the rule by which flights are judged.

    Attributes:
        positions: (M, 3) [m] (world).
        times: (M,) [s] of the reference.
        rule: CLOCK, CLOSEST or RELEASED.
        distance, crash, before, after, rate_crash, fly_on: as in `JudgeSettings`; the window is endless for RELEASED.
        floor: [m] height below which a drone has crashed.
    """

    positions: Any
    times: Any
    rule: int
    distance: float
    crash: float
    before: float
    after: float
    rate_crash: float
    fly_on: bool
    floor: float


class Verdicts(NamedTuple):
    """Results of B flights over M gates so far; only the judge writes them, one row a flight. Names as in `Flights`.

    Attributes:
        clocked: (B,) gates whose reference time has come.
        opened: (B,) first gate whose window is still open.
        ticks: (B,) control periods flown.
    """

    gates_passed: Any
    end: Any
    end_time: Any
    end_position: Any
    lap_time: Any
    clock_distance: Any
    closest_distance: Any
    closest_time: Any
    mean_error: Any
    max_error: Any
    clocked: Any
    opened: Any
    ticks: Any


def gates_of(settings: JudgeSettings, positions: NDArray[np.float64], times: NDArray[np.float64], floor: float | None) -> Gates:
    """The gates and the rule of a race, as compiled code takes them.

    Args:
        settings: how it is judged.
        positions: shape (M, 3) [m] (world).
        times: shape (M,) [s] of the reference.
        floor: [m] of the track, or None.
    """
    before, after = settings.window if settings.rule is not GateRule.RELEASED else (math.inf, math.inf)
    return Gates(
        np.ascontiguousarray(positions, dtype=np.float64),
        np.ascontiguousarray(times, dtype=np.float64),
        _RULES[settings.rule],
        float(settings.distance),
        float(settings.crash),
        float(before),
        float(after),
        float(settings.rate_crash),
        bool(settings.fly_on),
        -math.inf if floor is None else float(floor),
    )


def new_verdicts(flights: int, gates: int) -> Verdicts:
    """The results of flights that have not begun."""

    def rows(*shape: int, value: float = math.nan) -> NDArray[np.float64]:
        """Real numbers of each flight."""
        return np.full((flights, *shape), value)

    def counts(value: int = 0) -> NDArray[np.int64]:
        """A whole number of each flight."""
        return np.full(flights, value, dtype=np.int64)

    return Verdicts(
        gates_passed=counts(),
        end=counts(FLYING),
        end_time=rows(),
        end_position=rows(3),
        lap_time=rows(),
        clock_distance=rows(gates),
        closest_distance=rows(gates),
        closest_time=rows(gates),
        mean_error=rows(value=0.0),
        max_error=rows(value=0.0),
        clocked=counts(),
        opened=counts(),
        ticks=counts(),
    )


@njit(**INLINE)
def judge(v: Verdicts, i: int, g: Gates, start: float, before: Any, time: float, now: Any, reference: Any, fastest_rate: float) -> bool:
    """Judge one control period of flight i; returns whether the flight is over.

    Args:
        v: its row i is brought up to date.
        i: the flight.
        g: what is judged.
        start: [s] of the period.
        before: [m] (world) position there.
        time: [s] of its end.
        now: [m] (world) position there.
        reference: [m] (world) of the reference at its end.
        fastest_rate: [rad/s] largest body rate at its end.
    """
    error = _distance(now, reference)
    v.ticks[i] += 1
    if not (error <= g.crash and fastest_rate <= g.rate_crash and now[2] >= g.floor):  # a NaN is a crash
        return _crash(v, i, g, time, now, error)
    v.mean_error[i] += (error - v.mean_error[i]) / v.ticks[i]
    v.max_error[i] = max(v.max_error[i], error)
    _approach(v, i, g, start, before, time, now)
    first = v.clocked[i]
    _clock(v, i, g, start, before, time, now)
    if g.rule == CLOCK:
        _decide_by_clock(v, i, g, first, start, before, time, now)
        over = v.clocked[i] == len(g.times)
    elif g.rule == CLOSEST:
        over = _decide_by_approach(v, i, g, time, now)
    else:
        over = _decide_at_the_end(v, i, g, time, now)
    return over or (v.end[i] == MISSED and not g.fly_on)


@njit(**INLINE)
def _distance(a: Any, b: Any) -> float:
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@njit(**INLINE)
def _end(v: Verdicts, i: int, how: int, time: float, position: Any) -> None:
    """Record how a flight ended; only the first end counts."""
    if v.end[i] == FLYING:
        v.end[i] = how
        v.end_time[i] = time
        for k in range(3):
            v.end_position[i, k] = position[k]


@njit(**INLINE)
def _crash(v: Verdicts, i: int, g: Gates, time: float, now: Any, error: float) -> bool:
    """End a flight by a crash; one that has passed every gate had finished before."""
    if v.gates_passed[i] == len(g.times):
        return _finish(v, i, v.closest_time[i, -1], now)
    if error >= 0:  # not for a NaN
        v.mean_error[i] += (error - v.mean_error[i]) / v.ticks[i]
        v.max_error[i] = max(v.max_error[i], error)
    _end(v, i, CRASHED, time, now)
    return True


@njit(**INLINE)
def _finish(v: Verdicts, i: int, lap_time: float, now: Any) -> bool:
    """End a flight that has passed every gate."""
    if v.end[i] == FLYING:
        v.lap_time[i] = lap_time
    _end(v, i, FINISHED, lap_time, now)
    return True


@njit(**INLINE)
def _approach(v: Verdicts, i: int, g: Gates, start: float, before: Any, time: float, now: Any) -> None:
    """Closest approach to every gate whose window is open: within the period, to the straight line."""
    while v.opened[i] < len(g.times) and g.times[v.opened[i]] + g.after < start:
        v.opened[i] += 1
    length = (now[0] - before[0]) ** 2 + (now[1] - before[1]) ** 2 + (now[2] - before[2]) ** 2
    for k in range(v.opened[i], len(g.times)):
        earliest, latest = max(start, g.times[k] - g.before), min(time, g.times[k] + g.after)
        if earliest > latest:
            break
        along = 0.0
        for j in range(3):
            along += (g.positions[k, j] - before[j]) * (now[j] - before[j])
        share = along / length if length > 0 else 0.0
        share = min(max(share, (earliest - start) / (time - start)), (latest - start) / (time - start))
        square = 0.0
        for j in range(3):
            square += (before[j] + share * (now[j] - before[j]) - g.positions[k, j]) ** 2
        if not v.closest_distance[i, k] ** 2 <= square:  # also where there is none yet
            v.closest_distance[i, k] = math.sqrt(square)
            v.closest_time[i, k] = start + share * (time - start)


@njit(**INLINE)
def _clock(v: Verdicts, i: int, g: Gates, start: float, before: Any, time: float, now: Any) -> None:
    """Distance from every gate that the reference passes within the period, at that time."""
    while v.clocked[i] < len(g.times) and g.times[v.clocked[i]] <= time:
        k = v.clocked[i]
        share = (g.times[k] - start) / (time - start)
        square = 0.0
        for j in range(3):
            square += (before[j] + share * (now[j] - before[j]) - g.positions[k, j]) ** 2
        v.clock_distance[i, k] = math.sqrt(square)
        v.clocked[i] += 1


@njit(**INLINE)
def _decide_by_clock(v: Verdicts, i: int, g: Gates, first: int, start: float, before: Any, time: float, now: Any) -> None:
    """Rule CLOCK: closer than d at t_r(i), or the flight ends there (Eq. 6)."""
    for k in range(first, v.clocked[i]):
        share = (g.times[k] - start) / (time - start)
        place = (
            before[0] + share * (now[0] - before[0]),
            before[1] + share * (now[1] - before[1]),
            before[2] + share * (now[2] - before[2]),
        )
        if not v.clock_distance[i, k] < g.distance:
            _end(v, i, MISSED, g.times[k], place)
        if v.end[i] == FLYING:
            v.gates_passed[i] += 1
            if k == len(g.times) - 1:
                _finish(v, i, g.times[k], place)


@njit(**INLINE)
def _decide_by_approach(v: Verdicts, i: int, g: Gates, time: float, now: Any) -> bool:
    """Rule CLOSEST: closer than d at some time within the window; a lap ends when the drone flies away from the last gate."""
    last = len(g.times) - 1
    while v.end[i] == FLYING and v.gates_passed[i] <= last:
        k = v.gates_passed[i]
        if v.closest_distance[i, k] < g.distance:
            v.gates_passed[i] += 1
        elif g.times[k] + g.after <= time:
            _end(v, i, MISSED, time, now)
        else:
            break
    if v.gates_passed[i] > last and (v.closest_time[i, last] < time or g.times[last] + g.after <= time):
        return _finish(v, i, v.closest_time[i, last], now)
    return g.times[last] + g.after <= time


@njit(**INLINE)
def _decide_at_the_end(v: Verdicts, i: int, g: Gates, time: float, now: Any) -> bool:
    """Rule RELEASED: closer than d at some time of the whole flight; the last gate is not checked (as in the released code)."""
    last = len(g.times) - 1
    while v.gates_passed[i] < last and v.closest_distance[i, v.gates_passed[i]] < g.distance:
        v.gates_passed[i] += 1
    if v.clocked[i] <= last:
        return False
    if v.gates_passed[i] == last:
        v.gates_passed[i] += 1
        return _finish(v, i, g.times[last], now)
    _end(v, i, MISSED, time, now)
    return True
