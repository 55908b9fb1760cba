"""Gate planes: the geometry of openings, for the planner, the judge and pictures.

A plane has a centre and three axes: the normal, along which it is passed, left and up. A point of it is (left, up) from the centre.
The rim distance of such a point is signed: negative inside the opening, by how far a circle around it may grow before it meets the rim.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from hotlap.race.gate import Gate, PassingDirection

Floats = NDArray[np.float64]
MIRRORED = np.diag([-1.0, -1.0, 1.0])  # half a turn about up


@dataclass(frozen=True)
class GatePlane:
    """An opening with its orientation, turned so that it is passed along its normal.

    Attributes:
        centre: shape (3,) [m] (world).
        rotation: shape (3, 3), world from gate: its columns are normal, left and up.
        corners: shape (k, 2) [m] (gate) of a polygon, counter-clockwise; shape (0, 2) where it is round.
        radius: [m] of a round opening; 0 where it is a polygon.
        depth: [m] of a tunnel.
        frame: [m] width of the frame; 0: none.
        one_way: whether only a passage along the normal counts.
        solid: whether something stands around it, so that the vehicle's own size counts; False where only an orientation is given.
    """

    centre: Floats
    rotation: Floats
    corners: Floats
    radius: float
    depth: float
    frame: float
    one_way: bool
    solid: bool

    @property
    def normal(self) -> Floats:
        """Unit vector along which it is passed, shape (3,) (world)."""
        return self.rotation[:, 0]

    @cached_property
    def edges(self) -> tuple[Floats, Floats]:
        """Outward normals (k, 2) (gate) and offsets (k,) [m] of a polygon's edges: inside where normal . point <= offset."""
        outward = outward_normals(self.corners)
        return outward, (outward * self.corners).sum(axis=1)

    @cached_property
    def middle(self) -> tuple[Floats, float]:
        """Centre (2,) [m] (gate) and radius [m] of the largest circle within the opening."""
        if not len(self.corners):
            return np.zeros(2), self.radius
        return _largest_circle(*self.edges)

    @property
    def room(self) -> float:
        """[m] radius of the largest circle within the opening."""
        return self.middle[1]

    def turned(self) -> GatePlane:
        """The same opening, passed the other way."""
        return replace(self, rotation=self.rotation @ MIRRORED, corners=(self.corners * np.array([-1.0, 1.0]))[::-1])

    def to_gate(self, points: Floats) -> Floats:
        """Points (world) seen from the gate: along the normal, left and up, shape (..., 3) [m]."""
        return (points - self.centre) @ self.rotation

    def rim_distance(self, points: Floats) -> Floats:
        """Signed distance of points (left, up) of the plane, shape (..., 2), from the rim [m]: negative inside.

        Outside of a polygon's corners it is the distance from the nearest edge's line, a little less than that from the rim.
        """
        if not len(self.corners):
            return np.linalg.norm(points, axis=-1) - self.radius
        outward, offsets = self.edges
        return (points @ outward.T - offsets).max(axis=-1)

    def outline(self, grown: float = 0.0, points: int = 32) -> Floats:
        """The rim, or what lies outside of it by a distance [m], as points in order, shape (k, 3) [m] (world)."""
        flat = _grown(*self.edges, grown) if len(self.corners) else (self.radius + grown) * _circle(points)
        return self.centre + flat @ self.rotation[:, 1:].T


def plane_of(gate: Gate, free_radius: float) -> GatePlane | None:
    """The plane of a gate that has an orientation; None for a point or a ball.

    Args:
        gate: as it is written.
        free_radius: [m] of the circle that stands in where the gate has an orientation alone.
    """
    if not gate.oriented:
        return None
    corners = gate.polygon
    radius = 0.0 if len(corners) else float(gate.radius or free_radius)
    one_way = gate.direction is not PassingDirection.EITHER
    plane = GatePlane(np.array(gate.position), gate.rotation, corners, radius, gate.depth, gate.frame, one_way, gate.shaped)
    return plane.turned() if gate.direction is PassingDirection.BACKWARD else plane


def outward_normals(corners: Floats) -> Floats:
    """Unit normals of a convex polygon's edges, shape (k, 2): from each corner to the next.

    Args:
        corners: shape (k, 2), counter-clockwise.
    """
    along = np.roll(corners, -1, axis=0) - corners
    return np.stack([along[:, 1], -along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None]


def _circle(points: int) -> Floats:
    angles = np.linspace(0, 2 * math.pi, points, endpoint=False)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _grown(outward: Floats, offsets: Floats, distance: float) -> Floats:
    """Corners of a convex polygon whose edges are moved outward by a distance [m]."""
    before, behind = np.roll(outward, 1, axis=0), offsets + distance
    return np.array([np.linalg.solve([a, b], [x, y]) for a, b, x, y in zip(before, outward, np.roll(behind, 1), behind, strict=True)])


def _largest_circle(outward: Floats, offsets: Floats) -> tuple[Floats, float]:
    """Centre and radius of the largest circle within a convex polygon: it touches three edges, or two that are parallel."""
    rows = np.column_stack([outward, np.ones(len(outward))])
    best, radius = np.zeros(2), float(offsets.min())
    for edges in combinations(range(len(offsets)), 3):
        chosen = rows[list(edges)]
        if abs(np.linalg.det(chosen)) < 1e-9:
            continue
        *centre, found = np.linalg.solve(chosen, offsets[list(edges)])
        if found > radius + 1e-12 and (rows @ [*centre, found] <= offsets + 1e-9).all():
            best, radius = np.array(centre), float(found)
    return best, radius
