"""Solids: what stands on a track and must not be touched, with its name: obstacles, frames, walls, floor."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hotlap.race.bodies import Ball, Band, Body, Polygon, Prism, Ring, Wall
from hotlap.race.gate_plane import Floats, GatePlane, plane_of
from hotlap.race.obstacles import Box, Pole
from hotlap.race.track import Track

UPRIGHT = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # columns: z, x, y of the world
FAR = 1e5  # m: half of the length of a pole with one end


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
        """Whether it bounds the course."""
        return isinstance(self.bodies[0], Wall)

    @property
    def ground(self) -> bool:
        """Whether it bounds the course from below: start and gates may stand on it."""
        return isinstance(self.bodies[0], Wall) and self.bodies[0].normal[2] > 0

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
