"""Encounters: what a path touches on a track, and where it crosses the planes of gates.

The path is a row of positions, joined by straight lines: rows every few millimetres or milliseconds are needed for a verdict. The vehicle
is a ball around its centre.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from hotlap.race.gate_plane import Floats, GatePlane
from hotlap.race.solids import solids_of
from hotlap.race.track import Track

TOUCH = 1e-4  # m: what overlaps by less does not touch


class EncounterKind(StrEnum):
    """What a path touches."""

    FRAME = "frame"
    OBSTACLE = "obstacle"
    BOX = "box"
    FLOOR = "floor"
    CEILING = "ceiling"


@dataclass(frozen=True)
class Encounter:
    """One thing that a path touches.

    Attributes:
        kind: of it.
        name: "the frame of gate 4", "pole 2", "the box", "the floor", "the ceiling".
        time: [s] when it is touched most deeply.
        distance: [m] how deep the vehicle reaches into it, negative.
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
    """Everything that a path touches, in order of time, once for each stretch of touching.

    Args:
        times: shape (rows,) [s].
        positions: shape (rows, 3) [m] (world) of the vehicle's centre.
        track: frames, obstacles, box, floor and ceiling.
        radius: [m] of the vehicle.
        free_radius: [m] of the circle that stands for a gate that has an orientation alone.
    """
    found = _boundaries(times, positions, track, radius)
    for solid in solids_of(track, free_radius):
        kind = EncounterKind.OBSTACLE if solid.plane is None else EncounterKind.FRAME
        found += _stretches(times, solid.measure(positions)[0] - radius, kind, solid.name)
    return tuple(sorted(found, key=lambda encounter: encounter.time))


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


def _stretches(times: Floats, distances: Floats, kind: EncounterKind, name: str) -> list[Encounter]:
    """One encounter for each stretch of touching: where the distance [m] is smallest."""
    below = np.concatenate([[False], distances < -TOUCH, [False]])
    starts, ends = np.flatnonzero(below[1:] & ~below[:-1]), np.flatnonzero(below[:-1] & ~below[1:])
    rows = [start + int(distances[start:end].argmin()) for start, end in zip(starts, ends, strict=True)]
    return [Encounter(kind, name, float(times[row]), float(distances[row])) for row in rows]
