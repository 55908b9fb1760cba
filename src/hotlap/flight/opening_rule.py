"""The rule "opening": gates are passed where the drone crosses their planes inside of their openings, in order and in their directions."""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from hotlap.flight.numbers import INLINE, INNER
from hotlap.flight.openings import BALL, meet
from hotlap.flight.planes import between
from hotlap.flight.verdicts import FINISHED, FLYING, MISSED, Gates, Verdicts, approach, end_flight, finish

TOUCHING = 1e-9  # m: how far a passage beside a gate lies outside at least


@njit(**INNER)
def decide_by_openings(v: Verdicts, i: int, g: Gates, start: float, before: Any, time: float, now: Any) -> bool:
    """Judge all gates whose windows are open within a period, of which several may be passed; returns whether nothing is left to see.

    Gates behind the next one are measured too, for flights that go on after a miss; what was seen before their turn is forgotten.
    """
    last, turn, waiting = len(g.times) - 1, start, False
    while v.opened[i] <= last and g.closes[v.opened[i]] < start:
        v.opened[i] += 1
    length = (now[0] - before[0]) ** 2 + (now[1] - before[1]) ** 2 + (now[2] - before[2]) ** 2
    far = math.sqrt(length)
    for k in range(v.opened[i], last + 1):
        if g.opens[k] > time:
            waiting = True
            break
        approach(v, i, g, k, length, max(start, g.opens[k]), min(time, g.closes[k]), start, before, time, now)
        if g.openings.kinds[k] == BALL:
            turn = _near_ball(v, i, g, k, turn, start, before, time, now)
        elif k > v.gates_passed[i] or _awaited(v, i, k):
            turn = _through_plane(v, i, g, k, turn, start, before, time, now, far)
        if g.closes[k] <= time:
            _close(v, i, k, time, now)
        elif g.openings.kinds[k] == BALL or math.isnan(v.rim_distance[i, k]):
            waiting = True
    if v.gates_passed[i] > last and (v.closest_time[i, last] < time or g.closes[last] <= time):
        finish(v, i, v.closest_time[i, last], now)
    return v.end[i] == FINISHED or (v.end[i] == MISSED and not waiting)


@njit(**INLINE)
def _awaited(v: Verdicts, i: int, k: int) -> bool:
    """Whether gate k is the next one of a flight that has missed none."""
    return v.end[i] == FLYING and v.gates_passed[i] == k


@njit(**INLINE)
def _through_plane(
    v: Verdicts, i: int, g: Gates, k: int, turn: float, start: float, before: Any, time: float, now: Any, length: float
) -> float:
    """Look for a passage of gate k by a straight line of a length [m]; returns the time from which on the next gate may be passed [s]."""
    o = g.openings
    share, rim, way, apart = meet(o, k, v.entered[i], v.worst[i], before, now, length)
    moment = start + share * (time - start)
    if share > 1 or moment < turn or moment < g.opens[k] or moment > g.closes[k]:
        return turn
    if rim > 0 and (way != o.ways[k] or apart >= o.nears[k]):  # the plane of this gate, but another part of the track
        return turn
    if not v.rim_distance[i, k] <= rim:
        v.rim_distance[i, k] = rim
    if not _awaited(v, i, k):
        return turn
    place = between(before, now, share)
    if rim > 0:
        if rim >= o.bands[k]:
            end_flight(v, i, MISSED, moment, place)
        return turn
    _count(v, i, g, k, moment, start, before, time, now)
    if k == len(g.times) - 1:
        finish(v, i, moment, place)
    return moment


@njit(**INLINE)
def _near_ball(v: Verdicts, i: int, g: Gates, k: int, turn: float, start: float, before: Any, time: float, now: Any) -> float:
    """Look for a passage of a gate without orientation: its closest approach; returns as `_through_plane`."""
    v.rim_distance[i, k] = v.closest_distance[i, k] + g.openings.sizes[k]
    if not (_awaited(v, i, k) and v.rim_distance[i, k] <= 0):
        return turn
    moment = _entrance(g, k, max(turn, g.opens[k]), start, before, time, now)
    _count(v, i, g, k, moment, start, before, time, now)
    return moment


@njit(**INLINE)
def _count(v: Verdicts, i: int, g: Gates, k: int, moment: float, start: float, before: Any, time: float, now: Any) -> None:
    """Count gate k as passed, and begin to look for the next one."""
    v.gates_passed[i] += 1
    following = k + 1
    if following < len(g.times):
        v.rim_distance[i, following] = math.nan
        v.entered[i, following] = 0
        if g.openings.kinds[following] == BALL:
            v.closest_distance[i, following] = math.nan
            length = (now[0] - before[0]) ** 2 + (now[1] - before[1]) ** 2 + (now[2] - before[2]) ** 2
            earliest, latest = max(moment, g.opens[following]), min(time, g.closes[following])
            approach(v, i, g, following, length, earliest, latest, start, before, time, now)


@njit(**INLINE)
def _entrance(g: Gates, k: int, since: float, start: float, before: Any, time: float, now: Any) -> float:
    """Time at which a straight line that comes into a ball enters it, not before another time [s]."""
    inward, ahead, length = 0.0, 0.0, 0.0
    for j in range(3):
        inward += (before[j] - g.positions[k, j]) ** 2
        ahead += (before[j] - g.positions[k, j]) * (now[j] - before[j])
        length += (now[j] - before[j]) ** 2
    root = ahead**2 - length * (inward - g.openings.sizes[k] ** 2)
    share = (-ahead - math.sqrt(root)) / length if root > 0 and length > 0 else 0.0
    return max(since, start + min(max(share, 0.0), 1.0) * (time - start))


@njit(**INLINE)
def _close(v: Verdicts, i: int, k: int, time: float, now: Any) -> None:
    """The window of gate k has closed: where it was not crossed, its distance is that of the closest approach, and it was missed."""
    if math.isnan(v.rim_distance[i, k]):
        v.rim_distance[i, k] = max(v.closest_distance[i, k], TOUCHING)
    if _awaited(v, i, k):
        end_flight(v, i, MISSED, time, now)
