"""Openings: the gates of the rule "opening" as plain arrays, and where a flight passes one.

A plane goes on for ever, and a track may cross it in other places: in a hairpin, where gates stand above each other, in another lap. What
counts is the crossing that belongs to the gate: near where the reference crosses it, the way the reference does, and in its time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.core.errors import HotlapError
from hotlap.flight.numbers import INLINE
from hotlap.flight.planes import Planes, between, corner_distance, planes_of, reach, rim_distance
from hotlap.race.gate_plane import GatePlane, plane_of
from hotlap.race.race import JudgeSettings
from hotlap.race.track import Track
from hotlap.reference.reference import Reference

Floats = NDArray[np.float64]
BALL, ONE_WAY, EITHER_WAY = range(3)  # kinds of gate as compiled code knows them
NEAR = 4.0  # times the size of an opening: a crossing further away is none of this gate


class Openings(NamedTuple):
    """The M gates that count, in the order flown.

    Attributes:
        kinds: (M,) BALL, ONE_WAY or EITHER_WAY.
        planes: of the gates; rows of no meaning for balls.
        sizes: (M,) [m] that the vehicle's own size takes from the opening; the radius of a ball with its sign turned.
        bands: (M,) [m] from the rim outwards in which the frame is touched, which is a crash and no miss; 0 without a frame.
        rooms: (M,) [m] radius of the largest circle in what is left.
        ways: (M,) 1 or -1: the way in which the reference crosses, along the normal or against it.
        places: (M, 2) [m] (gate) where it does.
        nears: (M,) [m] from there within which a crossing belongs to the gate.
    """

    kinds: Any
    planes: Planes
    sizes: Any
    bands: Any
    rooms: Any
    ways: Any
    places: Any
    nears: Any


@dataclass(frozen=True)
class _Passage:
    """How the reference crosses a gate: its way, its place (2,) [m] (gate), how near is near [m], and the window of its time [s]."""

    way: float
    place: Floats
    near: float
    window: tuple[float, float]


def openings_of(track: Track, judge: JudgeSettings, radius: float, reference: Reference) -> tuple[Openings, Floats]:
    """The gates of a track as the rule "opening" reads them.

    Args:
        track: that is flown.
        judge: its settings.
        radius: [m] of the vehicle.
        reference: that is followed.

    Returns:
        The gates, and their windows: from and until when a passage counts, shape (M, 2) [s].

    Raises:
        HotlapError: an opening is too small for the vehicle.
    """
    gates, planes = track.counted, [plane_of(gate, judge.distance) for gate in track.counted]
    balls = [-(gate.radius or judge.distance) for gate in gates]
    sizes = [ball if plane is None else radius * plane.solid for ball, plane in zip(balls, planes, strict=True)]
    rooms = [-size if plane is None else plane.room - size for size, plane in zip(sizes, planes, strict=True)]
    for room, size, point in zip(rooms, sizes, (point for point in track.route if point.counts), strict=True):
        if room <= 0:
            sizes_of_both = f"its opening has room for a radius of {room + size:.3g} m, the vehicle has one of {size:.3g} m"
            raise HotlapError(f"{track.name}, {point.name}: {sizes_of_both}")
    positions = track.gate_positions
    passages = [_passage(plane, k, positions, judge.window, reference) for k, plane in enumerate(planes)]
    kinds = [BALL if plane is None else ONE_WAY if plane.one_way else EITHER_WAY for plane in planes]
    openings = Openings(
        kinds=np.array(kinds, dtype=np.int64),
        planes=planes_of(planes),
        sizes=np.array(sizes),
        bands=np.array([gate.frame + 2 * size if gate.frame > 0 else 0.0 for gate, size in zip(gates, sizes, strict=True)]),
        rooms=np.array(rooms),
        ways=np.array([passage.way for passage in passages]),
        places=np.array([passage.place for passage in passages]),
        nears=np.array([passage.near for passage in passages]),
    )
    windows = np.array([passage.window for passage in passages])
    windows[:, 0] = np.minimum.accumulate(windows[::-1, 0])[::-1]  # in the order of the gates
    windows[:, 1] = np.maximum.accumulate(windows[:, 1])
    return openings, windows


def _passage(plane: GatePlane | None, k: int, positions: Floats, window: tuple[float, float], reference: Reference) -> _Passage:
    """How the reference passes gate k of those at positions (M, 3), and what tells that passage from others of the same plane or point."""
    time = float(reference.gate_times[k])
    first, last = time - window[0], time + window[1]
    if plane is None:
        apart = np.linalg.norm(positions - positions[k], axis=1)
        others = [float(reference.gate_times[n]) for n in np.flatnonzero(apart < 1e-6) if n != k]
        return _Passage(1.0, np.zeros(2), math.inf, _narrowed(time, first, last, others))
    found = _crossings(plane, reference)
    times, ways, places = (values[found[1] > 0] for values in found) if plane.one_way else found
    own = int(np.abs(times - time).argmin()) if len(times) else -1
    if own < 0 or abs(times[own] - time) > max(window):
        return _Passage(1.0, np.zeros(2), NEAR * corner_distance(plane), (first, last))
    way, place, size = float(ways[own]), places[own], corner_distance(plane)
    apart = np.linalg.norm(places - place, axis=1)
    rivals = (np.arange(len(times)) != own) & (ways == way) & (times > first - window[1]) & (times < last + window[0])
    elsewhere, again = rivals & (apart > 2 * size), rivals & (apart <= 2 * size)
    near = min(NEAR * size, float(apart[elsewhere].min(initial=math.inf)) / 2)
    return _Passage(way, place, near, _narrowed(time, first, last, times[again].tolist()))


def _narrowed(time: float, first: float, last: float, others: list[float]) -> tuple[float, float]:
    """A window up to half of the way to other passages of the same place."""
    earlier, later = [other for other in others if other < time], [other for other in others if other > time]
    return max([first, *((time + other) / 2 for other in earlier)]), min([last, *((time + other) / 2 for other in later)])


def _crossings(plane: GatePlane, reference: Reference) -> tuple[Floats, Floats, Floats]:
    """Where a reference crosses a plane: times (n,) [s], ways (n,) 1 or -1, and places (n, 2) [m] (gate)."""
    seen = plane.to_gate(reference.position)
    behind = seen[:, 0] >= 0
    rows = np.flatnonzero(behind[1:] != behind[:-1])
    before, now = seen[rows], seen[rows + 1]
    share = before[:, 0] / (before[:, 0] - now[:, 0])
    places = before[:, 1:] + share[:, None] * (now - before)[:, 1:]
    return (rows + share) * reference.period, np.where(behind[rows + 1], 1.0, -1.0), places


def _none() -> Openings:
    """Openings for the rules that ask for none."""
    empty = np.zeros(0)
    return Openings(np.zeros(0, dtype=np.int64), planes_of([]), empty, empty, empty, empty, np.zeros((0, 2)), empty)


NO_OPENINGS = _none()


@njit(**INLINE)
def meet(o: Openings, k: int, entered: Any, worst: Any, before: Any, now: Any, length: float) -> Any:
    """Whether a straight line passes the far end of gate k, in a direction that counts.

    Args:
        o: the gates.
        k: one with a plane.
        entered: (M,) the way in which the drone has entered the tunnel, 1 or -1; 0 outside. Brought up to date.
        worst: (M,) [m] largest distance from the rim since then, likewise.
        before: [m] (world) where the line begins.
        now: [m] (world) where it ends.
        length: [m] of the line.

    Returns:
        Share of the line at which it leaves the gate, 2 where it does not; signed distance from the rim with the vehicle's size, in a
        tunnel the largest [m]; the way, 1 or -1; and the distance from where the reference crosses [m].
    """
    p, half, way = o.planes, o.planes.halves[k], 1.0
    a = reach(p, k, 0, before)
    if abs(a) > half + 2.0 * length:  # too far away, as most gates are; twice, for rounding
        return 2.0, 0.0, way, 0.0
    b = reach(p, k, 0, now)
    if o.kinds[k] == EITHER_WAY and b < a:
        a, b, way = -a, -b, -1.0
    if not a < half <= b:
        if half > 0:
            _follow_tunnel(o, k, entered, worst, before, now, a, b, way)
        return 2.0, 0.0, way, 0.0
    share = (half - a) / (b - a)
    place = between(before, now, share)
    left, up = reach(p, k, 1, place), reach(p, k, 2, place)
    rim = rim_distance(p, k, left, up) + o.sizes[k]
    if half > 0:
        if a < -half:
            rim = max(rim, _rim_at(o, k, between(before, now, (-half - a) / (b - a))))
        elif entered[k] * way > 0:
            rim = max(rim, worst[k])
        else:
            share = 2.0
        entered[k] = 0
    return share, rim, way, math.sqrt((left - o.places[k, 0]) ** 2 + (up - o.places[k, 1]) ** 2)


@njit(**INLINE)
def _rim_at(o: Openings, k: int, point: Any) -> float:
    """Signed distance of a point (world) from the walls of gate k, with the vehicle's size [m]."""
    return rim_distance(o.planes, k, reach(o.planes, k, 1, point), reach(o.planes, k, 2, point)) + o.sizes[k]


@njit(**INLINE)
def _follow_tunnel(o: Openings, k: int, entered: Any, worst: Any, before: Any, now: Any, a: float, b: float, way: float) -> None:
    """Remember a drone that enters a tunnel, how near it comes to its walls, and that it has turned back.

    The distance from a convex rim is largest at an end of a straight line.
    """
    half = o.planes.halves[k]
    if a < -half <= b:
        entered[k] = int(way)
        worst[k] = max(_rim_at(o, k, between(before, now, (-half - a) / (b - a))), _rim_at(o, k, now))
    elif entered[k] != 0:
        if abs(b) > half:
            entered[k] = 0
        else:
            worst[k] = max(worst[k], _rim_at(o, k, now))
