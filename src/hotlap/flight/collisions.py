"""Collisions: whether a flight touches an obstacle or the frame of a gate.

The vehicle fills a ball. Its distance from the nearest object is how far it can fly before it must be looked at again, so that most control
periods cost one subtraction; where it is close, the straight line of the period is walked in steps that cannot jump over anything.

A frame is solid from the rim of its opening outwards. It is touched where the centre crosses its plane nearer to it than the vehicle's
radius, or comes nearer to its front or back than that.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from hotlap.core.records import Cause
from hotlap.flight.numbers import INLINE, INNER
from hotlap.flight.planes import Planes, between, planes_of, reach, rim_distance
from hotlap.race.gate_plane import GatePlane, plane_of
from hotlap.race.track import Track

FRAME, POLE, SPHERE, BOX = int(Cause.FRAME), int(Cause.POLE), int(Cause.SPHERE), int(Cause.BOX)
NONE = int(Cause.NONE)
LEAST_STEP = 1e-3  # m of a walk along a line: thinner contacts than its square over a radius are not seen
ENDLESS = 1e300  # m


class Objects(NamedTuple):
    """What must not be touched.

    Attributes:
        poles: (P, 5) x, y, radius, bottom and top [m] (world).
        spheres: (S, 4) centre and radius [m] (world).
        boxes: (B, 6) low and high corner [m] (world).
        frames: of the gates that have one.
        widths: (F,) [m] of the frames.
        spans: (F,) [m] from the centre of a gate, within which its frame is touched.
        gates: (F,) index of the gate in the track.
        radius: [m] of the vehicle.
        any: whether there is anything.
    """

    poles: Any
    spheres: Any
    boxes: Any
    frames: Planes
    widths: Any
    spans: Any
    gates: Any
    radius: float
    any: bool


def objects_of(track: Track, radius: float) -> Objects:
    """Obstacles and frames of a track as compiled code takes them.

    Args:
        track: that is flown.
        radius: [m] of the vehicle.
    """
    poles = [
        (*pole.position, pole.radius, -ENDLESS if pole.bottom is None else pole.bottom, ENDLESS if pole.top is None else pole.top)
        for pole in track.poles
    ]
    first = {point.key: point.gate for point in track.route if point.gate.frame > 0}
    planes = [plane for gate in first.values() if (plane := plane_of(gate, 0.0)) is not None]
    rows = {"poles": (poles, 5), "spheres": ([(*ball.position, ball.radius) for ball in track.spheres], 4)}
    rows["boxes"] = ([(*box.low, *box.high) for box in track.boxes], 6)
    arrays = {name: np.array(values, dtype=np.float64).reshape(-1, width) for name, (values, width) in rows.items()}
    return Objects(
        **arrays,
        frames=planes_of(planes),
        widths=np.array([gate.frame for gate in first.values()], dtype=np.float64),
        spans=np.array([_span(plane, radius) for plane in planes], dtype=np.float64),
        gates=np.array([int(key[len("gates[") : -1]) for key in first], dtype=np.int64),
        radius=float(radius),
        any=bool(first) or any(len(array) for array in arrays.values()),
    )


def _span(plane: GatePlane, radius: float) -> float:
    """[m] From the centre of a gate, within which its frame is touched."""
    outside = np.linalg.norm(plane.outline(plane.frame + radius) - plane.centre, axis=1).max()
    return float(math.hypot(outside, plane.depth / 2 + radius))


@njit(**INNER)
def touch(o: Objects, before: Any, now: Any, length: float, free: float) -> Any:
    """The first touch along a straight line.

    Args:
        o: what must not be touched.
        before: [m] (world) where the line begins.
        now: [m] (world) where it ends.
        length: [m] of the line.
        free: [m] of its beginning that are known to be free.

    Returns:
        Share of the line up to the touch, more than 1 where there is none; what is touched, a `Cause`; its index; and how far the vehicle
        may fly from the end of the line before something can be touched [m].
    """
    share, what, which, distance = 2.0, NONE, -1, 0.0
    if free > 0 or length > 0:
        distance, _, _ = _nearest(o, between(before, now, min(free / length, 1.0) if length > 0 else 0.0))
    if free + distance > length:
        return share, what, which, free + distance - length
    for n in range(len(o.widths)):
        crossed = _cross_frame(o, n, before, now)
        if crossed < share:
            share, what, which = crossed, FRAME, o.gates[n]
    end = min(share, 1.0) * length
    flown = free
    while flown <= end:
        distance, kind, index = _nearest(o, between(before, now, flown / length if length > 0 else 0.0))
        if distance <= 0:
            return (flown / length if length > 0 else 0.0), kind, index, 0.0
        flown += max(distance, LEAST_STEP)
    return share, what, which, flown - length


@njit(**INLINE)
def _cross_frame(o: Objects, n: int, before: Any, now: Any) -> float:
    """Share of a line at which it crosses one of the two faces of frame n where the vehicle touches it; 2 where it does not."""
    a, b, half, found = reach(o.frames, n, 0, before), reach(o.frames, n, 0, now), o.frames.halves[n], 2.0
    for side in range(2 if half > 0 else 1):
        face = half if side == 0 else -half
        if (a < face) != (b < face):
            share = (face - a) / (b - a)
            place = between(before, now, share)
            rim = rim_distance(o.frames, n, reach(o.frames, n, 1, place), reach(o.frames, n, 2, place))
            if -o.radius < rim < o.widths[n] + o.radius:
                found = min(found, share)
    return found


@njit(**INLINE)
def _nearest(o: Objects, point: Any) -> Any:
    """Distance of the vehicle at a point from the nearest object [m], which object that is, a `Cause`, and its index.

    The distance is never too long.
    """
    distance, what, which = ENDLESS, NONE, -1
    for n in range(len(o.poles)):
        aside = math.sqrt((point[0] - o.poles[n, 0]) ** 2 + (point[1] - o.poles[n, 1]) ** 2) - o.poles[n, 2]
        apart = _corner(aside, max(o.poles[n, 3] - point[2], point[2] - o.poles[n, 4])) - o.radius
        if apart < distance:
            distance, what, which = apart, POLE, n
    for n in range(len(o.spheres)):
        square = 0.0
        for j in range(3):
            square += (point[j] - o.spheres[n, j]) ** 2
        apart = math.sqrt(square) - o.spheres[n, 3] - o.radius
        if apart < distance:
            distance, what, which = apart, SPHERE, n
    for n in range(len(o.boxes)):
        square = 0.0
        for j in range(3):
            square += max(o.boxes[n, j] - point[j], point[j] - o.boxes[n, 3 + j], 0.0) ** 2
        apart = math.sqrt(square) - o.radius
        if apart < distance:
            distance, what, which = apart, BOX, n
    for n in range(len(o.widths)):
        square = 0.0
        for j in range(3):
            square += (point[j] - o.frames.centres[n, j]) ** 2
        if square > (distance + o.spans[n]) ** 2:  # further away than what is nearest so far
            continue
        apart = _frame_distance(o, n, point)
        if apart < distance:
            distance, what, which = apart, FRAME, o.gates[n]
    return distance, what, which


@njit(**INLINE)
def _frame_distance(o: Objects, n: int, point: Any) -> float:
    """Distance of a point from where frame n is touched [m]: its faces thickened by the vehicle's radius, or its plane widened by it."""
    rim = rim_distance(o.frames, n, reach(o.frames, n, 1, point), reach(o.frames, n, 2, point))
    along = abs(reach(o.frames, n, 0, point)) - o.frames.halves[n]
    aside = max(-rim, rim - o.widths[n])
    return min(_corner(aside, along - o.radius), _corner(aside - o.radius, along))


@njit(**INLINE)
def _corner(a: float, b: float) -> float:
    """Distance from a body that reaches to a = 0 in one direction and to b = 0 in another at right angles; 0 within."""
    return math.sqrt(max(a, 0.0) ** 2 + max(b, 0.0) ** 2)
