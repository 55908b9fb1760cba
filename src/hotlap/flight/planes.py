"""Planes: openings of gates as plain arrays for compiled code, and where a straight line crosses them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from hotlap.flight.numbers import INLINE
from hotlap.race.gate_plane import GatePlane


class Planes(NamedTuple):
    """Openings with their orientation, one row each; names as in `GatePlane`.

    Attributes:
        centres: (G, 3) [m] (world).
        rotations: (G, 3, 3) world from gate; the columns are normal, left and up.
        outward: (G, E, 2) outward normals of the edges of a polygon (gate); zeros behind its last one.
        offsets: (G, E) [m] of the edges; endless behind the last one.
        radii: (G,) [m] of a round opening; 0 where it is a polygon.
        halves: (G,) [m] half of the depth.
    """

    centres: Any
    rotations: Any
    outward: Any
    offsets: Any
    radii: Any
    halves: Any


def planes_of(planes: Sequence[GatePlane | None]) -> Planes:
    """Planes of gates as compiled code takes them; a gate without one has a row of no meaning.

    Args:
        planes: of each gate.
    """
    most = max((len(plane.corners) for plane in planes if plane is not None), default=0)
    found = Planes(
        centres=np.zeros((len(planes), 3)),
        rotations=np.tile(np.eye(3), (len(planes), 1, 1)),
        outward=np.zeros((len(planes), most, 2)),
        offsets=np.full((len(planes), most), math.inf),
        radii=np.zeros(len(planes)),
        halves=np.zeros(len(planes)),
    )
    for k, plane in enumerate(planes):
        if plane is None:
            continue
        found.centres[k], found.rotations[k] = plane.centre, plane.rotation
        found.radii[k], found.halves[k] = plane.radius, plane.depth / 2
        edges = len(plane.corners)
        if edges:
            found.outward[k, :edges], found.offsets[k, :edges] = plane.edges
    return found


@njit(**INLINE)
def between(before: Any, now: Any, share: float) -> Any:
    """The point of a straight line at a share of it, from 0 to 1."""
    return (
        before[0] + share * (now[0] - before[0]),
        before[1] + share * (now[1] - before[1]),
        before[2] + share * (now[2] - before[2]),
    )


@njit(**INLINE)
def reach(p: Planes, k: int, axis: int, point: Any) -> float:
    """[m] How far a point (world) lies from the centre of plane k along its normal (0), to the left (1) or up (2)."""
    total = 0.0
    for j in range(3):
        total += (point[j] - p.centres[k, j]) * p.rotations[k, j, axis]
    return total


@njit(**INLINE)
def rim_distance(p: Planes, k: int, left: float, up: float) -> float:
    """Signed distance of a point of plane k from the rim [m], negative inside, as `GatePlane.rim_distance`.

    Args:
        p: the planes.
        k: the plane.
        left: [m] (gate) of the point.
        up: [m] (gate) of the point.
    """
    if p.radii[k] > 0:
        return math.sqrt(left**2 + up**2) - p.radii[k]
    farthest = -math.inf
    for n in range(p.offsets.shape[1]):
        if p.offsets[k, n] < 1e300:
            farthest = max(farthest, p.outward[k, n, 0] * left + p.outward[k, n, 1] * up - p.offsets[k, n])
    return farthest


def corner_distance(plane: GatePlane) -> float:
    """[m] Distance of the farthest point of an opening's rim from its centre."""
    return float(np.linalg.norm(plane.corners, axis=1).max()) if len(plane.corners) else plane.radius
