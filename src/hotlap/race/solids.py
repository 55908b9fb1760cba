"""Solids: what stands on a track and must not be touched, as bodies whose distance from any point is known.

Distances are signed: negative inside. Each comes with the unit vector that leads away from the body fastest.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hotlap.race.gate_plane import Floats, GatePlane, plane_of
from hotlap.race.obstacles import Box, Pole
from hotlap.race.track import Track

UPRIGHT = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # columns: z, x, y of the world


class Body(Protocol):
    """A body in space."""

    @property
    def ball(self) -> tuple[Floats, float]:
        """Centre (3,) [m] (world) and radius [m] of a ball that it lies within."""
        ...

    def measure(self, points: Floats) -> tuple[Floats, Floats]:
        """Distances (n,) [m] of points (n, 3) (world), and unit vectors (n, 3) that lead away."""
        ...

    def around(self, distance: float, heights: Floats) -> Floats:
        """Points (k, 3) on all sides of it at about a distance [m]; endless bodies at heights (h,) [m] (world)."""
        ...


class Section(Protocol):
    """A flat figure, the same on the whole length of a body."""

    @property
    def size(self) -> float:
        """[m] largest distance of its points from the axis."""
        ...

    def measure(self, points: Floats) -> tuple[Floats, Floats]:
        """Distances (n,) [m] of points (n, 2), and unit vectors (n, 2) that lead away."""
        ...

    def around(self, distance: float) -> Floats:
        """Points (k, 2) around it at about a distance [m]."""
        ...


@dataclass(frozen=True)
class Ball:
    """A ball.

    Attributes:
        centre: shape (3,) [m] (world).
        radius: [m].
    """

    centre: Floats
    radius: float

    @property
    def ball(self) -> tuple[Floats, float]:
        """As of every body."""
        return self.centre, self.radius

    def measure(self, points: Floats) -> tuple[Floats, Floats]:
        """As of every body."""
        offsets = points - self.centre
        norms = np.linalg.norm(offsets, axis=1)
        return norms - self.radius, _units(offsets, norms)

    def around(self, distance: float, heights: Floats) -> Floats:  # noqa: ARG002  it ends
        """As of every body."""
        directions = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if x or y or z], dtype=float)
        return self.centre + _units(directions, np.linalg.norm(directions, axis=1)) * (self.radius + distance) * 1.1


@dataclass(frozen=True)
class Wall:
    """Everything beyond a plane.

    Attributes:
        normal: shape (3,) (world) unit vector away from the wall.
        place: [m] normal . point of its plane.
    """

    normal: Floats
    place: float

    @property
    def ball(self) -> tuple[Floats, float]:
        """As of every body."""
        return np.zeros(3), np.inf

    def measure(self, points: Floats) -> tuple[Floats, Floats]:
        """As of every body."""
        return points @ self.normal - self.place, np.tile(self.normal, (len(points), 1))

    def around(self, distance: float, heights: Floats) -> Floats:  # noqa: ARG002  there is no way around
        """As of every body."""
        return np.empty((0, 3))


@dataclass(frozen=True)
class Ring:
    """The section between two circles; a disc where the inner radius is zero.

    Attributes:
        inner, outer: radii [m].
    """

    inner: float
    outer: float

    @property
    def size(self) -> float:
        """As of every section."""
        return self.outer

    def measure(self, points: Floats) -> tuple[Floats, Floats]:
        """As of every section."""
        norms = np.linalg.norm(points, axis=1)
        out, units = norms - self.outer, _units(points, norms)
        if self.inner <= 0:
            return out, units
        hole = self.inner - norms > out
        return np.where(hole, self.inner - norms, out), np.where(hole[:, None], -units, units)

    def around(self, distance: float) -> Floats:
        """As of every section."""
        angles = np.linspace(0, 2 * np.pi, 8, endpoint=False)
        return (self.outer + distance) / np.cos(np.pi / 8) * np.stack([np.cos(angles), np.sin(angles)], axis=1)


@dataclass(frozen=True)
class Polygon:
    """A convex polygon.

    Attributes:
        corners: shape (k, 2) [m], counter-clockwise.
    """

    corners: Floats

    @property
    def size(self) -> float:
        """As of every section."""
        return float(np.linalg.norm(self.corners, axis=1).max())

    def measure(self, points: Floats) -> tuple[Floats, Floats]:
        """As of every section."""
        along = np.roll(self.corners, -1, axis=0) - self.corners
        lengths = np.linalg.norm(along, axis=1)
        outward = np.stack([along[:, 1], -along[:, 0]], axis=1) / lengths[:, None]
        offsets = points[:, None] - self.corners
        beyond = (offsets * outward).sum(axis=2)
        nearest_edge = beyond.argmax(axis=1)
        inside = beyond.max(axis=1) <= 0
        shares = ((offsets * along).sum(axis=2) / lengths**2).clip(0, 1)
        away = offsets - shares[..., None] * along
        norms = np.linalg.norm(away, axis=2)
        nearest, rows = norms.argmin(axis=1), np.arange(len(points))
        distances = np.where(inside, beyond[rows, nearest_edge], norms[rows, nearest])
        flat = inside | (distances < 1e-9)
        return distances, np.where(flat[:, None], outward[nearest_edge], _units(away[rows, nearest], norms[rows, nearest]))

    def around(self, distance: float) -> Floats:
        """As of every section."""
        along = np.roll(self.corners, -1, axis=0) - self.corners
        outward = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None]
        before = np.roll(outward, 1, axis=0)
        corners = self.corners + 1.1 * distance * (before + outward) / (1 + (before * outward).sum(axis=1))[:, None]
        return np.vstack([corners, (corners + np.roll(corners, -1, axis=0)) / 2])


@dataclass(frozen=True)
class Band:
    """The section between two polygons.

    Attributes:
        inner: the hole.
        outer: the edge.
    """

    inner: Polygon
    outer: Polygon

    @property
    def size(self) -> float:
        """As of every section."""
        return self.outer.size

    def measure(self, points: Floats) -> tuple[Floats, Floats]:
        """As of every section."""
        hole, inwards = self.inner.measure(points)
        out, outwards = self.outer.measure(points)
        return np.maximum(-hole, out), np.where((-hole > out)[:, None], -inwards, outwards)

    def around(self, distance: float) -> Floats:
        """As of every section."""
        return self.outer.around(distance)


@dataclass(frozen=True)
class Prism:
    """A section on a length.

    Attributes:
        centre: shape (3,) [m] (world).
        rotation: shape (3, 3), world from prism: columns are its axis and the two axes of its section.
        section: what it is across.
        half: [m] of its length; infinite where it has no end.
    """

    centre: Floats
    rotation: Floats
    section: Section
    half: float

    @property
    def ball(self) -> tuple[Floats, float]:
        """As of every body."""
        return self.centre, self.half + self.section.size

    def measure(self, points: Floats) -> tuple[Floats, Floats]:
        """As of every body."""
        local = (points - self.centre) @ self.rotation
        across, sideways = self.section.measure(local[:, 1:])
        along = np.abs(local[:, 0]) - self.half
        outside = np.stack([np.maximum(along, 0.0), np.maximum(across, 0.0)], axis=1)
        norms = np.linalg.norm(outside, axis=1)
        inner = np.maximum(along, across)
        weights = np.where((norms > 1e-12)[:, None], _units(outside, norms), np.stack([along >= across, along < across], axis=1))
        away = np.column_stack([weights[:, 0] * np.where(local[:, 0] < 0, -1.0, 1.0), weights[:, 1:] * sideways])
        return np.where(norms > 1e-12, norms, inner), away @ self.rotation.T

    def around(self, distance: float, heights: Floats) -> Floats:
        """As of every body."""
        flat = self.section.around(distance)
        if np.isfinite(self.half):
            places = [-self.half - distance, 0.0, self.half + distance]
        else:
            places = [float(height - self.centre[2]) for height in heights]
        ends = [np.column_stack([np.full(len(flat), place), flat]) for place in places]
        if np.isfinite(self.half):
            ends.append(np.array([[-self.half - 1.1 * distance, 0.0, 0.0], [self.half + 1.1 * distance, 0.0, 0.0]]))
        return self.centre + np.vstack(ends) @ self.rotation.T


@dataclass(frozen=True)
class Solid:
    """Something that must not be touched.

    Attributes:
        name: for messages: "pole 1", "the frame of gate 4".
        bodies: what it consists of.
        plane: of the gate whose frame or opening it is; None for an obstacle.
        opening: whether it is an opening that is not to be crossed, and not a frame.
    """

    name: str
    bodies: tuple[Body, ...]
    plane: GatePlane | None = None
    opening: bool = False

    @property
    def wall(self) -> bool:
        """Whether it bounds the course: start and gates may stand at it."""
        return isinstance(self.bodies[0], Wall)

    @cached_property
    def ball(self) -> tuple[Floats, float]:
        """Centre (3,) [m] (world) and radius [m] of a ball that it lies within."""
        if self.plane is None:
            return self.bodies[0].ball
        corners = self.plane.outline(self.plane.frame) - self.plane.centre
        return self.plane.centre, float(np.linalg.norm(corners, axis=1).max()) + self.plane.depth / 2

    def near(self, points: Floats, distance: float) -> NDArray[np.bool_]:
        """Which of points (n, 3) may be within a distance [m]; quick."""
        centre, radius = self.ball
        return ((points - centre) ** 2).sum(axis=1) < (radius + distance) ** 2

    def measure(self, points: Floats) -> tuple[Floats, Floats]:
        """Distances (n,) [m] of points (n, 3) (world) from the nearest of its bodies, and unit vectors (n, 3) that lead away."""
        distances, away = self.bodies[0].measure(points)
        for body in self.bodies[1:]:
            others, directions = body.measure(points)
            away = np.where((others < distances)[:, None], directions, away)
            distances = np.minimum(distances, others)
        return distances, away

    def around(self, distance: float, heights: Floats) -> Floats:
        """Points (k, 3) on all sides of it at about a distance [m]; endless bodies at heights (h,) [m] (world)."""
        if self.plane is None or self.plane.frame == 0:
            return np.vstack([body.around(distance, heights) for body in self.bodies])
        plane = self.plane
        rim = plane.outline(plane.frame + 1.2 * distance, points=12)
        if len(plane.corners):
            rim = np.vstack([rim, (rim + np.roll(rim, -1, axis=0)) / 2])
        shift = (plane.depth / 2 + 1.1 * distance) * plane.normal
        middle = plane.centre + plane.rotation[:, 1:] @ plane.middle[0]
        return np.vstack([rim - shift, rim + shift, middle - 1.5 * shift, middle + 1.5 * shift])


def solids_of(track: Track, free_radius: float) -> tuple[Solid, ...]:
    """Obstacles and frames of a track; gates that stand at the same place have one frame.

    Args:
        track: what stands on it.
        free_radius: [m] as in `plane_of`.
    """
    solids = [Solid(f"pole {k}", (_pole(pole),)) for k, pole in enumerate(track.poles, 1)]
    solids += [Solid(f"sphere {k}", (Ball(np.array(sphere.position), sphere.radius),)) for k, sphere in enumerate(track.spheres, 1)]
    solids += [Solid(f"box {k}", (_box(box),)) for k, box in enumerate(track.boxes, 1)]
    for name, plane in gate_planes(track, free_radius):
        if plane.frame > 0 and not any(same_place(plane, known.plane) for known in solids):
            solids.append(Solid(f"the frame of {name}", _frame(plane), plane))
    return tuple(solids)


def walls_of(track: Track) -> tuple[Solid, ...]:
    """Box and ceiling of a track."""
    walls = []
    if track.ceiling is not None:
        walls.append(Solid("the ceiling", (Wall(np.array([0.0, 0.0, -1.0]), -track.ceiling),)))
    if track.box is not None:
        for axis, low, high in zip(np.eye(3), track.box.low, track.box.high, strict=True):
            walls += [Solid("the box", (Wall(axis, low),)), Solid("the box", (Wall(-axis, -high),))]
    return tuple(walls)


def floor_at(height: float) -> Solid:
    """The floor at a height [m] (world)."""
    return Solid("the floor", (Wall(np.array([0.0, 0.0, 1.0]), height),))


def gate_planes(track: Track, free_radius: float) -> list[tuple[str, GatePlane]]:
    """Names and planes of the gates of one lap that have an orientation."""
    lap = track.route[: len(track.gates)]
    planes = [(point.name.removesuffix(" of lap 1"), plane_of(point.gate, free_radius)) for point in lap]
    return [(name, plane) for name, plane in planes if plane is not None]


def same_place(one: GatePlane | None, other: GatePlane | None) -> bool:
    """Whether two planes are those of one frame, seen from either side."""
    if one is None or other is None:
        return False
    near = float(np.linalg.norm(one.centre - other.centre)) < 0.1 * min(one.room, other.room)
    return near and abs(float(one.normal @ other.normal)) > 0.99


def plug(name: str, plane: GatePlane) -> Solid:
    """The opening of a gate, closed."""
    section = Polygon(plane.corners) if len(plane.corners) else Ring(0.0, plane.radius)
    return Solid(name, (Prism(plane.centre, plane.rotation, section, plane.depth / 2),), plane, opening=True)


def _pole(pole: Pole) -> Prism:
    bottom, top = (-np.inf if pole.bottom is None else pole.bottom), (np.inf if pole.top is None else pole.top)
    if np.isfinite(bottom) and np.isfinite(top):
        return Prism(np.array([*pole.position, (bottom + top) / 2]), UPRIGHT, Ring(0.0, pole.radius), (top - bottom) / 2)
    if np.isfinite(top):
        return Prism(np.array([*pole.position, top - FAR]), UPRIGHT, Ring(0.0, pole.radius), FAR)
    if np.isfinite(bottom):
        return Prism(np.array([*pole.position, bottom + FAR]), UPRIGHT, Ring(0.0, pole.radius), FAR)
    return Prism(np.array([*pole.position, 0.0]), UPRIGHT, Ring(0.0, pole.radius), np.inf)


FAR = 1e5  # m: half of the length of a pole with one end


def _box(box: Box) -> Prism:
    low, high = np.array(box.low), np.array(box.high)
    x, y = (high - low)[:2] / 2
    return Prism((low + high) / 2, UPRIGHT, Polygon(np.array([[x, y], [-x, y], [-x, -y], [x, -y]])), float(high[2] - low[2]) / 2)


def _frame(plane: GatePlane) -> tuple[Body, ...]:
    """Between the rim and the outer edge."""
    if not len(plane.corners):
        return (Prism(plane.centre, plane.rotation, Ring(plane.radius, plane.radius + plane.frame), plane.depth / 2),)
    band = Band(Polygon(plane.corners), Polygon(plane.to_gate(plane.outline(plane.frame))[:, 1:]))
    return (Prism(plane.centre, plane.rotation, band, plane.depth / 2),)


def _units(vectors: Floats, norms: Floats) -> Floats:
    """Of length 1; what has no length points along the first axis."""
    units = vectors / np.maximum(norms, 1e-12)[:, None]
    units[norms < 1e-12] = np.eye(vectors.shape[1])[0]
    return units
