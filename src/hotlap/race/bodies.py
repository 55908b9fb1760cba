"""Bodies: shapes in space whose distance from any point is known, and the flat sections that they are made of.

Distances are signed: negative inside. Each comes with the unit vector that leads away from the body fastest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hotlap.race.gate_plane import Floats, outward_normals


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
        along, outward = np.roll(self.corners, -1, axis=0) - self.corners, outward_normals(self.corners)
        offsets = points[:, None] - self.corners
        beyond = (offsets * outward).sum(axis=2)
        nearest_edge = beyond.argmax(axis=1)
        inside = beyond.max(axis=1) <= 0
        shares = ((offsets * along).sum(axis=2) / np.linalg.norm(along, axis=1) ** 2).clip(0, 1)
        away = offsets - shares[..., None] * along
        norms = np.linalg.norm(away, axis=2)
        nearest, rows = norms.argmin(axis=1), np.arange(len(points))
        distances = np.where(inside, beyond[rows, nearest_edge], norms[rows, nearest])
        flat = inside | (distances < 1e-9)
        return distances, np.where(flat[:, None], outward[nearest_edge], _units(away[rows, nearest], norms[rows, nearest]))

    def around(self, distance: float) -> Floats:
        """As of every section."""
        outward = outward_normals(self.corners)
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


def _units(vectors: Floats, norms: Floats) -> Floats:
    """Of length 1; what has no length points along the first axis."""
    units = vectors / np.maximum(norms, 1e-12)[:, None]
    units[norms < 1e-12] = np.eye(vectors.shape[1])[0]
    return units
