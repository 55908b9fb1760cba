"""The judge: whether gates were passed, and how a flight ended (Eq. 6 of the paper, and the other rules).

It sees one flight at the ends of control periods, drawn as straight lines in between; worlds of all kinds call it.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from hotlap.core.records import Cause
from hotlap.flight.collisions import touch
from hotlap.flight.numbers import INLINE
from hotlap.flight.opening_rule import decide_by_openings
from hotlap.flight.planes import between
from hotlap.flight.verdicts import (
    CLOCK,
    CLOSEST,
    CRASHED,
    FLYING,
    MISSED,
    OPENING,
    TAKEN_OFF,
    Gates,
    Verdicts,
    approach,
    end_flight,
    finish,
    gates_of,
    new_verdicts,
)

__all__ = ["Gates", "Verdicts", "gates_of", "judge", "lose", "new_verdicts"]

NONE, NUMBERS, CEILING, OUTSIDE = int(Cause.NONE), int(Cause.NUMBERS), int(Cause.CEILING), int(Cause.OUTSIDE)
DISTANCE, RATE = int(Cause.DISTANCE), int(Cause.RATE)
SUNK = 0.5  # m below the floor, from which on a drone that has never taken off has crashed too


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
    if (v.ticks[i] == 1 and before[2] > g.floor + TAKEN_OFF) or now[2] > g.floor + TAKEN_OFF:
        v.airborne[i] = 1
    touched, cause, index = 2.0, NONE, -1
    if g.objects.any:
        touched, cause, index = _touch(v, i, g, before, now)
    if touched > 1:
        cause = _fault(g, now, error, fastest_rate, v.airborne[i] == 0)
    if touched > 1 and cause != NONE:
        return _crash(v, i, g, cause, index, time, now, error)
    v.mean_error[i] += (error - v.mean_error[i]) / v.ticks[i]
    v.max_error[i] = max(v.max_error[i], error)
    if touched > 1:
        return _pass_gates(v, i, g, start, before, time, now)
    moment, place = start + touched * (time - start), between(before, now, touched)
    if moment > start and _pass_gates(v, i, g, start, before, moment, place):
        return True
    return _crash(v, i, g, cause, index, moment, place, math.nan)


@njit(**INLINE)
def _touch(v: Verdicts, i: int, g: Gates, before: Any, now: Any) -> Any:
    """Share of a period at which the drone touches something, more than 1 where it does not; what it touches; and its index."""
    length = _distance(before, now)
    known = v.free[i]
    v.free[i] = known - length
    if v.free[i] > 0:
        return 2.0, NONE, -1
    share, cause, index, v.free[i] = touch(g.objects, before, now, length, max(known, 0.0))
    return share, cause, index


@njit(**INLINE)
def _fault(g: Gates, now: Any, error: float, fastest_rate: float, grounded: bool) -> int:
    """Why a drone has crashed that is at a place at the end of a period, a `Cause`; NONE where it has not."""
    if math.isnan(error) or math.isnan(fastest_rate):
        return NUMBERS
    if now[2] < g.floor and not (grounded and now[2] >= g.floor - SUNK):
        return g.floor_cause
    if now[2] > g.ceiling:
        return CEILING
    for j in range(3):
        if now[j] < g.low[j] or now[j] > g.high[j]:
            return OUTSIDE
    if fastest_rate > g.rate_crash:
        return RATE
    return DISTANCE if error > g.crash else NONE


@njit(**INLINE)
def _pass_gates(v: Verdicts, i: int, g: Gates, start: float, before: Any, time: float, now: Any) -> bool:
    """Judge the gates by the rule; returns whether the flight is over."""
    if g.rule != OPENING:
        _approach(v, i, g, start, before, time, now)
    first = v.clocked[i]
    _clock(v, i, g, start, before, time, now)
    if g.rule == CLOCK:
        _decide_by_clock(v, i, g, first, start, before, time, now)
        over = v.clocked[i] == len(g.times)
    elif g.rule == CLOSEST:
        over = _decide_by_approach(v, i, g, time, now)
    elif g.rule == OPENING:
        over = decide_by_openings(v, i, g, start, before, time, now)
    else:
        over = _decide_at_the_end(v, i, g, time, now)
    return over or (v.end[i] == MISSED and not g.fly_on)


@njit(**INLINE)
def lose(v: Verdicts, i: int, g: Gates, cause: int, time: float, now: Any, error: float) -> None:
    """End flight i at a time [s] and a place for a cause that the judge cannot see; one that has passed every gate had finished before."""
    _crash(v, i, g, cause, -1, time, now, error)


@njit(**INLINE)
def _distance(a: Any, b: Any) -> float:
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@njit(**INLINE)
def _crash(v: Verdicts, i: int, g: Gates, cause: int, index: int, time: float, now: Any, error: float) -> bool:
    """End a flight by a crash; one that has passed every gate had finished before."""
    if v.gates_passed[i] == len(g.times):
        return finish(v, i, v.closest_time[i, -1], now)
    if error >= 0:  # not for a NaN
        v.mean_error[i] += (error - v.mean_error[i]) / v.ticks[i]
        v.max_error[i] = max(v.max_error[i], error)
    if v.end[i] == FLYING:
        v.cause[i], v.cause_index[i] = cause, index
    end_flight(v, i, CRASHED, time, now)
    return True


@njit(**INLINE)
def _approach(v: Verdicts, i: int, g: Gates, start: float, before: Any, time: float, now: Any) -> None:
    """Closest approach to every gate whose window is open."""
    while v.opened[i] < len(g.times) and g.times[v.opened[i]] + g.after < start:
        v.opened[i] += 1
    length = (now[0] - before[0]) ** 2 + (now[1] - before[1]) ** 2 + (now[2] - before[2]) ** 2
    for k in range(v.opened[i], len(g.times)):
        if not approach(v, i, g, k, length, max(start, g.times[k] - g.before), min(time, g.times[k] + g.after), start, before, time, now):
            break


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
            end_flight(v, i, MISSED, g.times[k], place)
        if v.end[i] == FLYING:
            v.gates_passed[i] += 1
            if k == len(g.times) - 1:
                finish(v, i, g.times[k], place)


@njit(**INLINE)
def _decide_by_approach(v: Verdicts, i: int, g: Gates, time: float, now: Any) -> bool:
    """Rule CLOSEST: closer than d at some time within the window; a lap ends when the drone flies away from the last gate."""
    last = len(g.times) - 1
    while v.end[i] == FLYING and v.gates_passed[i] <= last:
        k = v.gates_passed[i]
        if v.closest_distance[i, k] < g.distance:
            v.gates_passed[i] += 1
        elif g.times[k] + g.after <= time:
            end_flight(v, i, MISSED, time, now)
        else:
            break
    if v.gates_passed[i] > last and (v.closest_time[i, last] < time or g.times[last] + g.after <= time):
        return finish(v, i, v.closest_time[i, last], now)
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
        return finish(v, i, g.times[last], now)
    end_flight(v, i, MISSED, time, now)
    return True
