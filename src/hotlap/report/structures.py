"""Structures: what stands on a track, as lines in space: gates with their openings, obstacles, the box, floor and ceiling."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hotlap.race.gate_plane import GatePlane, plane_of
from hotlap.race.obstacles import Box, Pole, Sphere
from hotlap.race.track import Gate, Track, Waypoint

Floats = NDArray[np.float64]
Obstacle = Pole | Sphere | Box

NEAR = 1.0  # of the track's longest extent: how far beyond it obstacles are still drawn
FITS = 0.6  # likewise, of the sides of the box, of floor and ceiling
EDGES = np.array([[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]])  # of a box's corners
BARB, SPREAD = 0.38, 0.45  # of an arrow's length: how long its head is, and half as wide as it is long


@dataclass(frozen=True)
class GateShape:
    """A gate as it is drawn.

    Attributes:
        gate: as the track has it.
        plane: its opening with its orientation; None for a point or a ball.
        radius: [m] of the circle that is drawn where there is no plane: the ball's own, or within which a point is passed.
        counts: whether a flight has to pass it.
        number: by which it is called, from 1 in each lap; 0 for a point that does not count.
    """

    gate: Gate
    plane: GatePlane | None
    radius: float
    counts: bool = True
    number: int = 0

    @property
    def centre(self) -> Floats:
        """Shape (3,) [m] (world)."""
        return np.array(self.gate.position)

    @property
    def bare(self) -> bool:
        """Whether it is a point without size or orientation."""
        return self.plane is None and not self.gate.radius

    @property
    def normal(self) -> Floats | None:
        """Unit vector (world) along which alone it is passed; None where both ways count."""
        return self.plane.normal if self.plane is not None and self.plane.one_way else None

    @cached_property
    def rims(self) -> tuple[Floats, ...]:
        """The opening's rim, at both ends of a tunnel, each shape (k, 3) [m] (world), the last point on the first; () without a plane."""
        return self._outlines(0.0)

    @cached_property
    def frames(self) -> tuple[Floats, ...]:
        """The outer rim of the frame, likewise; () where there is none."""
        return self._outlines(self.plane.frame) if self.plane is not None and self.plane.frame else ()

    @cached_property
    def walls(self) -> tuple[Floats, ...]:
        """Lines along a tunnel, from its corners at one end to those at the other, each shape (2, 3) [m] (world)."""
        if len(self.rims) < 2:
            return ()
        ends = np.stack([rim[:-1] for rim in self.rims], axis=1)
        return tuple(ends if len(ends) <= 12 else ends[:: len(ends) // 8])

    @property
    def lines(self) -> tuple[Floats, ...]:
        """Everything that is drawn of it in space."""
        return (*self.rims, *self.frames, *self.walls)

    @property
    def reach(self) -> float:
        """[m] from its centre to the farthest point of the opening, without the length of a tunnel."""
        return self.radius if self.plane is None else float(np.linalg.norm(self.plane.outline() - self.centre, axis=1).max())

    @property
    def bounds(self) -> Floats:
        """Least and largest coordinates of what is drawn, shape (2, 3) [m] (world)."""
        points = np.vstack(self.lines) if self.lines else self.centre + self.radius * np.array([[-1.0], [1.0]])
        return np.stack([points.min(axis=0), points.max(axis=0)])

    def larger(self, least: float) -> GateShape:
        """The same shape with a reach of at least so many metres, so that it can be seen on a long track; a bare point stays as it is."""
        factor = 1.0 if self.bare else least / self.reach
        if factor <= 1:
            return self
        if self.plane is None:
            return replace(self, radius=factor * self.radius)
        plane = self.plane
        grown = {name: factor * getattr(plane, name) for name in ("corners", "radius", "depth", "frame")}
        return replace(self, plane=replace(plane, **grown))

    def arrow(self, length: float) -> Floats | None:
        """A line along the normal from the centre, or from the end of a tunnel, of a length [m], shape (2, 3) [m] (world).

        None where both ways count.
        """
        if self.plane is None or self.normal is None:
            return None
        tail = self.centre + self.plane.depth / 2 * self.normal
        return np.stack([tail, tail + length * self.normal])

    def _outlines(self, grown: float) -> tuple[Floats, ...]:
        if self.plane is None:
            return ()
        outline = self.plane.outline(grown)
        outline = np.vstack([outline, outline[:1]])
        shifts = np.array([-0.5, 0.5]) * self.plane.depth if self.plane.depth else (0.0,)
        return tuple(outline + shift * self.plane.normal for shift in shifts)


@dataclass(frozen=True)
class Structures:
    """What stands on a track.

    Attributes:
        gates: those that have to be passed, in the order flown.
        points: those that do not count, each once, without the end.
        obstacles: poles, which stand on the floor where there is one, spheres and boxes.
        box: what the flight must not leave; None: it may go anywhere.
        floor: [m] (world) height; None: there is none, or it is not drawn, because nothing stands on it.
        ceiling: [m] (world) height; None: there is none.
    """

    gates: tuple[GateShape, ...]
    points: tuple[GateShape, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    box: Box | None = None
    floor: float | None = None
    ceiling: float | None = None

    @property
    def distinct(self) -> tuple[GateShape, ...]:
        """Gates and points without repetition: those of several laps once."""
        return tuple({shape.gate: shape for shape in (*self.points, *self.gates)}.values())

    @property
    def plain(self) -> bool:
        """Whether there are bare points alone."""
        bounded = self.box is not None or self.ceiling is not None
        return all(shape.bare and shape.counts for shape in self.distinct) and not self.obstacles and not bounded

    def surround(self, low: Floats, high: Floats) -> tuple[Floats, Floats]:
        """The box of a track, each shape (3,) [m], made larger by its structures; what is far away is left out."""
        corners = [low, high, *(corner for shape in self.distinct if not shape.bare for corner in shape.bounds)]
        low, high = np.min(corners, axis=0), np.max(corners, axis=0)
        extent = float((high - low).max())
        corners = [low, high]
        for obstacle in self.obstacles:
            least, most = bounds_of(obstacle)
            if (least <= high + NEAR * extent).all() and (most >= low - NEAR * extent).all():
                corners += [np.maximum(_finite(least, low), low - NEAR * extent), np.minimum(_finite(most, high), high + NEAR * extent)]
        for least, most in self._borders():
            corners += [np.where(least >= low - FITS * extent, _finite(least, low), low)]
            corners += [np.where(most <= high + FITS * extent, _finite(most, high), high)]
        return np.min(corners, axis=0), np.max(corners, axis=0)

    def _borders(self) -> Iterable[tuple[Floats, Floats]]:
        """Least and largest coordinates of the box, and of floor and ceiling, infinite where there are none."""
        if self.box is not None:
            yield np.array(self.box.low), np.array(self.box.high)
        yield _level(self.floor, -np.inf), _level(self.ceiling, np.inf)


def structures_of(track: Track, distance: float) -> Structures:
    """What stands on a track.

    Args:
        track: with its gates.
        distance: [m] within which a gate without size is passed.
    """
    counted = (point for point in track.route if point.counts)
    gates = tuple(_shape(point, distance, number) for point, number in zip(counted, track.gate_numbers, strict=True))
    others = {point.key: _shape(point, distance) for point in track.route if not point.counts and point.key != "end"}
    obstacles = (*(_standing(pole, track.floor) for pole in track.poles), *track.spheres, *track.boxes)
    found = Structures(gates, tuple(others.values()), obstacles, track.box, None, track.ceiling)
    return found if found.plain else replace(found, floor=track.floor)


def bounds_of(obstacle: Obstacle) -> tuple[Floats, Floats]:
    """Least and largest coordinates of an obstacle, each shape (3,) [m] (world); infinite where a pole is endless."""
    if isinstance(obstacle, Box):
        return np.array(obstacle.low), np.array(obstacle.high)
    if isinstance(obstacle, Sphere):
        return np.array(obstacle.position) - obstacle.radius, np.array(obstacle.position) + obstacle.radius
    x, y = obstacle.position
    bottom, top = (-np.inf if obstacle.bottom is None else obstacle.bottom), (np.inf if obstacle.top is None else obstacle.top)
    return np.array([x - obstacle.radius, y - obstacle.radius, bottom]), np.array([x + obstacle.radius, y + obstacle.radius, top])


def obstacle_lines(obstacle: Obstacle, low: Floats, high: Floats) -> tuple[Floats, ...]:
    """An obstacle as lines in space, each shape (k, 3) [m] (world).

    Args:
        obstacle: to be drawn.
        low: shape (3,) [m] of what is drawn: where an endless pole ends.
        high: likewise.
    """
    if isinstance(obstacle, Box):
        return box_lines(obstacle)
    centre, turned = np.array(obstacle.position), obstacle.radius * _circle()
    if isinstance(obstacle, Sphere):
        return tuple(centre + np.roll(turned, turn, axis=1) for turn in range(3))
    bottom, top = (_finite(bound, end)[2] for bound, end in zip(bounds_of(obstacle), (low, high), strict=True))
    rings = [np.append(centre, height) + turned for height in (bottom, max(bottom, top))]
    return (*rings, *np.stack([ring[:-1:8] for ring in rings], axis=1))


def box_lines(box: Box) -> tuple[Floats, ...]:
    """The twelve edges of a box, each shape (2, 3) [m] (world)."""
    ends = np.array([box.low, box.high])
    corners = np.array([[ends[i, 0], ends[j, 1], ends[k, 2]] for i in range(2) for j in range(2) for k in range(2)])
    return tuple(corners[EDGES])


def arrow_line(ends: Floats) -> Floats:
    """A flat arrow as one line through tail, tip, one barb, tip and the other barb, shape (5, 2).

    Args:
        ends: shape (2, 2), its tail and its tip.
    """
    tail, tip = ends
    back = BARB * (tail - tip)
    across = SPREAD * np.array([-back[1], back[0]])
    return np.stack([tail, tip, tip + back + across, tip, tip + back - across])


def _shape(point: Waypoint, distance: float, number: int = 0) -> GateShape:
    return GateShape(point.gate, plane_of(point.gate, distance), point.gate.radius or distance, point.counts, number)


def _standing(pole: Pole, floor: float | None) -> Pole:
    """An endless pole ends at the floor."""
    ends = floor is not None and pole.bottom is None and (pole.top is None or pole.top > floor)
    return pole.model_copy(update={"bottom": floor}) if ends else pole


def _circle(points: int = 33) -> Floats:
    """A circle of radius 1 in the plane of the first two axes, the last point on the first."""
    angles = np.linspace(0, 2 * np.pi, points)
    return np.stack([np.cos(angles), np.sin(angles), np.zeros(points)], axis=1)


def _level(height: float | None, none: float) -> Floats:
    return np.array([none, none, none if height is None else height])


def _finite(values: Floats, instead: Floats) -> Floats:
    return np.where(np.isfinite(values), values, instead)
