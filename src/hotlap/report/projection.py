"""Projection: how a track in space becomes a flat drawing: from above, from the side, or at a slant for the film.

The map in the terminal, the pictures, the map of the page and the film all take their geometry from here; each of them only draws.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from hotlap.report.scene import Scene
from hotlap.report.structures import BARB, SPREAD, GateShape, box_lines, obstacle_lines

Floats = NDArray[np.float64]

AXES = "xyz"
LEAST_EXTENT = 3.0  # m: a flat track is a strip, not a line
STRAY = 0.12  # of the extent: how far beyond the plan flights are still in the drawing
SLANT = math.radians(38)  # of the film's camera above the horizon
TURN = math.radians(12)  # off the track's long axis, so that straights do not hide behind each other
ARROW = 0.9  # of an opening's reach, in the film
GRID = 9  # lines of the ground in each direction


class Layer(IntEnum):
    """The parts of a drawing from above or from the side, in the order in which they are drawn: later ones cover earlier ones."""

    BORDER = 1
    OBSTACLE = 2
    GATE_AREA = 3
    COMPARISON = 4
    FLIGHT_EDGE = 5
    FLIGHT = 6
    PLAN = 7
    GATE_CIRCLE = 8
    START = 9
    FAILURE = 10
    LABEL = 11


@dataclass(frozen=True)
class View:
    """A projection along one world axis, from above or from the side, within limits.

    Attributes:
        across: world axis that runs across the drawing: 0 is x, 1 is y.
        up: world axis that runs up.
        low: shape (2,) [m] limits at the left and lower edges; `low[0] > high[0]` where the axis runs to the left.
        high: shape (2,) [m] limits at the right and upper edges.
    """

    across: int
    up: int
    low: Floats
    high: Floats

    @property
    def extent(self) -> Floats:
        """Width and height of the drawing, shape (2,) [m]."""
        return np.abs(self.high - self.low)

    @property
    def signs(self) -> Floats:
        """Shape (2,): -1 where coordinates grow to the left or downwards, else 1."""
        return np.sign(self.high - self.low)

    def project(self, points: Floats) -> Floats:
        """The two coordinates that a drawing shows of world positions, shape (n, 3) to (n, 2) [m]."""
        return points[:, [self.across, self.up]]

    def clip(self, points: Floats) -> Floats:
        """Projected positions, shape (n, 2); those beyond the limits are moved to the nearest edge."""
        return np.clip(points, np.minimum(self.low, self.high), np.maximum(self.low, self.high))

    def place(self, points: Floats, scale: float) -> Floats:
        """Projected positions measured from the lower left corner, to the right and up, in units of the drawing, shape (n, 2).

        Args:
            points: shape (n, 2) [m].
            scale: units of the drawing per metre.
        """
        return (points - self.low) * self.signs * scale

    def place_from_middle(self, points: Floats, scale: float) -> Floats:
        """Projected positions measured from the middle of the drawing, to the right and up; arguments as for `place`."""
        return (points - (self.low + self.high) / 2) * self.signs * scale

    def title(self, sizes: Floats) -> str:
        """From where the view looks, with the directions of its axes: "from above: x→ 51 m, y↑ 20 m".

        Args:
            sizes: shape (3,) [m] of what is drawn along x, y and z.
        """
        name, arrow = "the side" if self.up == 2 else "above", "→" if self.across == 0 else "←"
        return f"from {name}: {AXES[self.across]}{arrow} {sizes[self.across]:.0f} m, {AXES[self.up]}↑ {sizes[self.up]:.0f} m"


def views_of(low: Floats, high: Floats) -> tuple[View, View]:
    """The views of a box from above and from the side, each shape (3,) [m]; the longer of x and y runs across both (y to the left)."""
    across = 0 if high[0] - low[0] >= high[1] - low[1] else 1
    left, right = (low, high) if across == 0 else (high, low)
    above, side = (View(across, up, np.array([left[across], low[up]]), np.array([right[across], high[up]])) for up in (1 - across, 2))
    return above, side


def box_of(points: Floats) -> tuple[Floats, Floats]:
    """Least and largest coordinates of points, each shape (3,) [m]."""
    return points.min(axis=0), points.max(axis=0)


def widen(low: Floats, high: Floats, least: float, margin: float = 0.0) -> tuple[Floats, Floats]:
    """A box made larger on all sides.

    Args:
        low: shape (3,) [m].
        high: shape (3,) [m].
        least: [m] extent that each side has at least afterwards.
        margin: added on every side, as a share of the longest extent.
    """
    extent = high - low
    padding = np.maximum(margin * float(extent.max()), (least - extent) / 2)
    return low - padding, high + padding


def scene_views(scene: Scene) -> tuple[View, View]:
    """A scene from above and from the side: the plan with its gates, and flights as far as they do not stray too far from it."""
    bare = np.array([gate.centre for gate in scene.structures.gates if gate.bare]).reshape(-1, 3)
    low, high = scene.structures.surround(*box_of(np.vstack([scene.path, bare - scene.distance, bare + scene.distance])))
    known = np.stack([low, high])
    margin = STRAY * float((high - low).max())
    flown = [flight.position for flight in scene.traces] + [repeats.failures for repeats in scene.repeats]
    everything = np.vstack([known, *(np.clip(points, low - margin, high + margin) for points in flown)])
    return views_of(*widen(*box_of(everything), LEAST_EXTENT, margin=0.03))


@dataclass(frozen=True)
class Camera:
    """A parallel projection in any direction.

    Attributes:
        right: shape (3,) unit vector (world) that runs to the right in the picture.
        up: shape (3,) unit vector (world) that runs up in the picture.
    """

    right: Floats
    up: Floats

    def project(self, points: Floats) -> Floats:
        """World positions, shape (..., 3) [m], in the picture, shape (..., 2) [m]."""
        return np.stack([points @ self.right, points @ self.up], axis=-1)


def aim(points: Floats) -> Camera:
    """A camera that looks down at a slant, with the longest horizontal extent of some points, shape (n, 3), across the picture."""
    flat = points[:, :2] - points[:, :2].mean(axis=0)
    along = np.linalg.svd(flat, full_matrices=False)[2][0]
    angle = math.atan2(along[1], along[0])
    if math.cos(angle) < 0:  # x or y to the right, as far as that can be chosen
        angle += math.pi
    angle += TURN
    right = np.array([math.cos(angle), math.sin(angle), 0.0])
    away = np.array([-math.sin(angle), math.cos(angle), 0.0])
    return Camera(right, math.sin(SLANT) * away + math.cos(SLANT) * np.array([0.0, 0.0, 1.0]))


def rings(centres: Floats, normals: Floats, radius: float | Floats, points: int = 33) -> Floats:
    """Circles in space, shape (n, points, 3) [m].

    Args:
        centres: shape (n, 3) [m].
        normals: shape (n, 3), of any length; where a normal is 0, the circle is upright and faces along x.
        radius: [m] of all, or shape (n,) of each.
        points: of each, the last on the first.
    """
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    axes = np.where(lengths > 1e-9, normals / np.maximum(lengths, 1e-9), [1.0, 0.0, 0.0])
    helper = np.where(np.abs(axes[:, 2:]) > 0.9, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    first = np.cross(axes, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(axes, first)
    angles = np.linspace(0, 2 * np.pi, points)[:, None]
    return centres[:, None] + np.reshape(radius, (-1, 1, 1)) * (np.cos(angles) * first[:, None] + np.sin(angles) * second[:, None])


def gate_rings(scene: Scene) -> Floats:
    """Gates as circles across the planned velocity, shape (M, points, 3) [m] (world)."""
    reference, radii = scene.reference, np.array([shape.radius for shape in scene.structures.gates])
    rows = np.clip(np.round(reference.gate_times / reference.period).astype(int), 0, len(reference.velocity) - 1)
    return rings(scene.gates, reference.velocity[rows], radii)


def gate_lines(scene: Scene, least: float) -> tuple[tuple[Floats, ...], ...]:
    """Lines of each gate, each shape (k, 3) [m] (world): its opening and the way in which it is passed, or a circle across the plan.

    Args:
        scene: with its gates.
        least: [m] reach of an opening that can be seen.
    """
    rings = gate_rings(scene)
    return tuple(_opening_lines(shape.larger(least)) or (ring,) for shape, ring in zip(scene.structures.gates, rings, strict=True))


def standing_lines(scene: Scene) -> tuple[Floats, ...]:
    """Obstacles and the box as lines, each shape (k, 3) [m] (world), as far as they stand near the track."""
    structures = scene.structures
    low, high = structures.surround(*box_of(scene.path))
    ground = np.append(low[:2], max(low[2], ground_level(scene)))
    lines = [line for obstacle in structures.obstacles for line in obstacle_lines(obstacle, ground, high)]
    lines += box_lines(structures.box) if structures.box is not None else ()
    return tuple(line for line in lines if ((line >= low - 1e-9) & (line <= high + 1e-9)).all())


def _opening_lines(shape: GateShape) -> tuple[Floats, ...]:
    """Rims, walls and arrow of an opening; () for a point or a ball."""
    length = ARROW * shape.reach
    arrow = shape.arrow(length)
    if shape.plane is None or arrow is None:
        return (*shape.rims, *shape.walls)
    left, _ = shape.plane.rotation[:, 1:].T
    tail, tip = arrow
    barbs = [tip - BARB * (tip - tail) + side * SPREAD * BARB * length * left for side in (1, -1)]
    return (*shape.rims, *shape.walls, np.stack([tail, tip, barbs[0], tip, barbs[1]]))


def ground_level(scene: Scene) -> float:
    """Height [m] of the ground that is drawn: the floor on which something stands, else below all of the plan."""
    if scene.structures.floor is not None:
        return scene.structures.floor
    return float(min(scene.path[:, 2].min(), scene.gates[:, 2].min()) - 1.5 * scene.distance)


def ground_grid(scene: Scene) -> Floats:
    """Lines of a square grid on the ground below the plan, shape (n, 2, 3) [m] (world)."""
    low, high = scene.path[:, :2].min(axis=0), scene.path[:, :2].max(axis=0)
    middle, half = (low + high) / 2, (high - low).max() / 2 * 1.25
    level, steps = ground_level(scene), np.linspace(-half, half, GRID)
    across = [[[middle[0] + s, middle[1] - half, level], [middle[0] + s, middle[1] + half, level]] for s in steps]
    along = [[[middle[0] - half, middle[1] + s, level], [middle[0] + half, middle[1] + s, level]] for s in steps]
    return np.array(across + along)


def shadow(scene: Scene) -> Floats:
    """The planned path on the ground, shape (rows, 3) [m] (world)."""
    return np.column_stack([scene.path[:, :2], np.full(len(scene.path), ground_level(scene))])


def picture_box(scene: Scene, camera: Camera) -> tuple[Floats, Floats]:
    """The box of plan, shadow and gates in a camera's picture, with a margin, each shape (2,) [m]."""
    corners = np.vstack([shape.bounds for shape in scene.structures.distinct if not shape.bare] or [scene.gates])
    low, high = box_of(camera.project(np.vstack([scene.path, scene.gates, shadow(scene), corners])))
    margin = 0.06 * float((high - low).max()) + (scene.distance if any(shape.bare for shape in scene.structures.gates) else 0.0)
    return low - margin, high + margin
