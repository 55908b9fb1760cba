"""Encounters: what a path meets on a track: gates that it passes or misses, and what it touches.

The path is a row of positions, joined by straight lines: rows every few millimetres or milliseconds are needed for a verdict. The vehicle
is a ball around its centre.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from hotlap.race.gate_plane import Floats, GatePlane, plane_of
from hotlap.race.solids import Solid, gate_planes, same_place, solids_of
from hotlap.race.track import Track, Waypoint

TOUCH = 1e-4  # m: what overlaps by less does not touch
RIM = 1e-3  # m: by how much the vehicle may overlap a rim
SAME_MOMENT = 0.01  # s by which a crossing and the passage that it is may differ


class EncounterKind(StrEnum):
    """What a path meets.

    PASSED: a gate that counts, in its turn, inside of its opening and in its direction.
    MISSED: a gate that counts and is not passed in its turn; the gates behind it are not looked for.
    WRONG_WAY: the opening of a gate that counts, crossed against its direction.
    FRAME, OBSTACLE, BOX, FLOOR, CEILING: touched.
    """

    PASSED = "passed"
    MISSED = "missed"
    WRONG_WAY = "wrong way"
    FRAME = "frame"
    OBSTACLE = "obstacle"
    BOX = "box"
    FLOOR = "floor"
    CEILING = "ceiling"


@dataclass(frozen=True)
class Encounter:
    """One thing that a path meets.

    Attributes:
        kind: what happens.
        name: of what is met: "gate 3", "the frame of gate 4", "pole 2", "the box", "the floor", "the ceiling".
        time: [s] when; of a gate that is missed: of the passage before it; of what is touched: when it is touched most deeply.
        distance: [m] signed: of a gate's rim from the centre of the vehicle where it crosses the plane, negative inside (of a
            ball or point: from its surface); of what is touched: how deep the vehicle reaches into it, negative. NaN for a missed gate.
    """

    kind: EncounterKind
    name: str
    time: float
    distance: float


@dataclass(frozen=True)
class Crossings:
    """Where a path crosses a plane.

    Attributes:
        times: shape (crossings,) [s].
        forward: shape (crossings,) whether along the normal.
        rims: shape (crossings,) [m] signed distances from the rim, negative inside.
    """

    times: Floats
    forward: np.ndarray
    rims: Floats


def find_encounters(times: Floats, positions: Floats, track: Track, radius: float, free_radius: float) -> tuple[Encounter, ...]:
    """Everything that a path meets, in order of time.

    Args:
        times: shape (rows,) [s].
        positions: shape (rows, 3) [m] (world) of the vehicle's centre.
        track: gates, obstacles, box, floor and ceiling.
        radius: [m] of the vehicle.
        free_radius: [m] how close a point without an opening has to be passed, and the circle of a gate that has an orientation alone.
    """
    passages = find_gate_passages(times, positions, track, radius, free_radius)
    found = [*passages, *_wrong_ways(times, positions, track, free_radius, passages)]
    found += touches(times, positions, solids_of(track, free_radius), radius)
    found += _boundaries(times, positions, track, radius)
    return tuple(sorted(found, key=lambda encounter: encounter.time))


def find_gate_passages(times: Floats, positions: Floats, track: Track, radius: float, free_radius: float) -> list[Encounter]:
    """The gates that count, passed one after the other, each as early as it can be; ends with the first that is missed.

    Args:
        times: as for `find_encounters`.
        positions: likewise.
        track: likewise.
        radius: likewise.
        free_radius: likewise.
    """
    found: list[Encounter] = []
    now = -np.inf
    for waypoint in (point for point in track.route if point.counts):
        later = [passage for passage in _passages(times, positions, waypoint, radius, free_radius, now) if passage.time > now]
        if not later:
            return [*found, Encounter(EncounterKind.MISSED, waypoint.name, max(now, float(times[0])), np.nan)]
        found.append(later[0])
        now = later[0].time
    return found


def touches(times: Floats, positions: Floats, solids: tuple[Solid, ...], radius: float) -> list[Encounter]:
    """What is touched, one encounter for each stretch of touching."""
    found = []
    for solid in solids:
        kind = EncounterKind.OBSTACLE if solid.plane is None else EncounterKind.FRAME
        found += _stretches(times, solid.measure(positions)[0] - radius, kind, solid.name)
    return found


def _passages(times: Floats, positions: Floats, waypoint: Waypoint, radius: float, free_radius: float, after: float) -> list[Encounter]:
    """All passages of one gate that would count, in order of time; of a ball those after a time [s]."""
    plane = plane_of(waypoint.gate, free_radius)
    if plane is None:
        reach = waypoint.gate.radius or free_radius
        distances = np.linalg.norm(positions - np.array(waypoint.gate.position), axis=1) - reach - RIM
        return _stretches(times, np.where(times > after, distances, np.inf), EncounterKind.PASSED, waypoint.name, least=0.0)
    crossings, size = find_crossings(times, positions, plane), radius if plane.solid else 0.0
    counts = (crossings.rims + size <= RIM) & (crossings.forward | (not plane.one_way))
    return [
        Encounter(EncounterKind.PASSED, waypoint.name, float(time), float(rim))
        for time, rim in zip(crossings.times[counts], crossings.rims[counts], strict=True)
    ]


def find_crossings(times: Floats, positions: Floats, plane: GatePlane) -> Crossings:
    """All crossings of a plane, however far from the opening.

    Args:
        times: shape (rows,) [s].
        positions: shape (rows, 3) [m] (world).
        plane: of a gate.
    """
    local = plane.to_gate(positions)
    ahead = local[:, 0] >= 0
    rows = np.flatnonzero(ahead[1:] != ahead[:-1])
    before, after = local[rows], local[rows + 1]
    shares = before[:, 0] / (before[:, 0] - after[:, 0])
    places = before + shares[:, None] * (after - before)
    moments = times[rows] + shares * (times[rows + 1] - times[rows])
    return Crossings(moments, ahead[rows + 1], plane.rim_distance(places[:, 1:]))


def _wrong_ways(times: Floats, positions: Floats, track: Track, free_radius: float, passages: list[Encounter]) -> list[Encounter]:
    """Openings crossed against their direction, unless the same frame is passed that way in its turn."""
    counted = [point for point in track.route if point.counts]
    passed = [(passage.time, plane_of(point.gate, free_radius)) for passage, point in zip(passages, counted, strict=False)]
    names = {point.name.removesuffix(" of lap 1") for point in counted}
    found = []
    for name, plane in gate_planes(track, free_radius):
        if not plane.one_way or name not in names:
            continue
        crossings = find_crossings(times, positions, plane)
        for time, rim in zip(crossings.times, np.where(crossings.forward, np.inf, crossings.rims), strict=True):
            in_turn = any(abs(time - moment) < SAME_MOMENT and same_place(plane, other) for moment, other in passed)
            if rim < -RIM and not in_turn:
                found.append(Encounter(EncounterKind.WRONG_WAY, name, float(time), float(rim)))
    return found


def _boundaries(times: Floats, positions: Floats, track: Track, radius: float) -> list[Encounter]:
    """Where the path leaves the box or comes too near to the ceiling; below the floor, or the lower side of the box, with its centre."""
    found = []
    if track.box is not None:
        low, high = positions - np.array(track.box.low), np.array(track.box.high) - positions
        low[:, 2] += radius  # a drone may stand there, as on a floor
        found += _stretches(times, np.minimum(low, high).min(axis=1) - radius, EncounterKind.BOX, "the box")
    if track.ceiling is not None:
        found += _stretches(times, track.ceiling - radius - positions[:, 2], EncounterKind.CEILING, "the ceiling")
    if track.floor is not None:
        found += _stretches(times, positions[:, 2] - track.floor, EncounterKind.FLOOR, "the floor")
    return found


def _stretches(times: Floats, distances: Floats, kind: EncounterKind, name: str, least: float = -TOUCH) -> list[Encounter]:
    """One encounter for each stretch of distances [m] below the least: where it is smallest."""
    below = np.concatenate([[False], distances < least, [False]])
    starts, ends = np.flatnonzero(below[1:] & ~below[:-1]), np.flatnonzero(below[:-1] & ~below[1:])
    rows = [start + int(distances[start:end].argmin()) for start, end in zip(starts, ends, strict=True)]
    return [Encounter(kind, name, float(times[row]), float(distances[row])) for row in rows]
