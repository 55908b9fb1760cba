"""What a path does at the gates of a track, judged from its positions alone, beside what it touches."""

from __future__ import annotations

import numpy as np

from hotlap.race.gate_plane import Floats, plane_of
from hotlap.race.solids import gate_planes, same_place
from hotlap.race.track import Track, Waypoint
from hotlap.reference.encounters import find_crossings, find_encounters

RIM = 1e-3  # m: by how much the vehicle may overlap a rim
SAME_MOMENT = 0.01  # s by which a crossing and the passage that it is may differ

PASSED, MISSED, WRONG_WAY = "passed", "missed", "wrong way"
Passage = tuple[float, float]
Met = tuple[str, str, float, float]
"""What happens, to what, when [s], and the signed distance from a rim or of what is touched [m]."""


def find_all(times: Floats, positions: Floats, track: Track, radius: float, free_radius: float) -> list[Met]:
    """Everything that a path meets, in order of time; arguments as for `find_encounters`."""
    passed = find_passed(times, positions, track, radius, free_radius)
    touched = find_encounters(times, positions, track, radius, free_radius)
    found = [*passed, *wrong_ways(times, positions, track, free_radius, passed)]
    found += [(str(one.kind), one.name, one.time, one.distance) for one in touched]
    return sorted(found, key=lambda one: one[2])


def find_passed(times: Floats, positions: Floats, track: Track, radius: float, free_radius: float) -> list[Met]:
    """The gates that count, passed one after the other, each as early as it can be; ends with the first that is missed."""
    found: list[Met] = []
    now = -np.inf
    for waypoint in (point for point in track.route if point.counts):
        later = [one for one in _passages(times, positions, waypoint, radius, free_radius, now) if one[0] > now]
        if not later:
            return [*found, (MISSED, waypoint.name, max(now, float(times[0])), np.nan)]
        now, distance = later[0]
        found.append((PASSED, waypoint.name, now, distance))
    return found


def _passages(times: Floats, positions: Floats, waypoint: Waypoint, radius: float, free_radius: float, after: float) -> list[Passage]:
    """All passages of one gate that would count; of a ball the nearest place of the first stretch within it after a time [s]."""
    plane = plane_of(waypoint.gate, free_radius)
    if plane is None:
        reach = waypoint.gate.radius or free_radius
        distances = np.linalg.norm(positions - np.array(waypoint.gate.position), axis=1) - reach - RIM
        rows = np.flatnonzero((distances < 0) & (times > after))
        stretch = np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)[0]
        nearest = stretch[distances[stretch].argmin()] if len(stretch) else None
        return [] if nearest is None else [(float(times[nearest]), float(distances[nearest]))]
    crossings, size = find_crossings(times, positions, plane), radius if plane.solid else 0.0
    counts = (crossings.rims + size <= RIM) & (crossings.forward | (not plane.one_way))
    return list(zip(crossings.times[counts].tolist(), crossings.rims[counts].tolist(), strict=True))


def wrong_ways(times: Floats, positions: Floats, track: Track, free_radius: float, passed: list[Met]) -> list[Met]:
    """Openings of gates that count, crossed against their direction, unless the same frame is passed that way in its turn."""
    counted = [point for point in track.route if point.counts]
    own = [(one[2], plane_of(point.gate, free_radius)) for one, point in zip(passed, counted, strict=False)]
    names = {point.name.removesuffix(" of lap 1") for point in counted}
    found: list[Met] = []
    for name, plane in gate_planes(track, free_radius):
        if not plane.one_way or name not in names:
            continue
        crossings = find_crossings(times, positions, plane)
        for time, rim in zip(crossings.times, np.where(crossings.forward, np.inf, crossings.rims), strict=True):
            in_turn = any(abs(time - moment) < SAME_MOMENT and same_place(plane, other) for moment, other in own)
            if rim < -RIM and not in_turn:
                found.append((WRONG_WAY, name, float(time), float(rim)))
    return found
