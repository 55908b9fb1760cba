"""Silhouettes: obstacles, box, floor and ceiling as flat shapes, as they are seen from above or from the side."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.race.obstacles import Box, Pole, Sphere
from hotlap.report.projection import View
from hotlap.report.structures import GateShape, Obstacle, Structures, bounds_of

Floats = NDArray[np.float64]

SEEN = 0.35  # of an arrow's length that is seen at least; else it points at the reader, and the other view shows it
VERTICAL = 2  # axis


@dataclass(frozen=True)
class Disc:
    """A filled circle.

    Attributes:
        centre: shape (2,) [m].
        radius: [m]
    """

    centre: Floats
    radius: float


@dataclass(frozen=True)
class Slab:
    """A filled rectangle.

    Attributes:
        low: shape (2,) [m] least coordinates.
        high: shape (2,) [m] largest coordinates.
    """

    low: Floats
    high: Floats

    @property
    def outline(self) -> Floats:
        """Its corners in order, the last on the first, shape (5, 2) [m]."""
        (left, bottom), (right, top) = self.low, self.high
        return np.array([[left, bottom], [right, bottom], [right, top], [left, top], [left, bottom]])


def silhouette(obstacle: Obstacle, view: View, least: float = 0.0) -> Disc | Slab:
    """An obstacle in a view.

    Args:
        obstacle: to be drawn.
        view: from above or from the side; endless poles reach its edges.
        least: [m] radius, or half of a width, that it is drawn with at least.
    """
    if isinstance(obstacle, Sphere) or (isinstance(obstacle, Pole) and view.up != VERTICAL):
        return Disc(np.array(obstacle.position)[[view.across, view.up]], max(obstacle.radius, least))
    low, high = (bound[[view.across, view.up]] for bound in bounds_of(obstacle))
    low, high = (np.where(np.isfinite(bound), bound, edge) for bound, edge in zip((low, high), _edges(view), strict=True))
    thicker = np.maximum(0.0, least - (high - low) / 2)
    return Slab(low - thicker, high + thicker)


def borders(structures: Structures, view: View) -> Iterator[Floats]:
    """Sides of the box, floor and ceiling as lines in a view, as far as they lie within it, each shape (2, 2) [m]."""
    low, high = _edges(view)
    if structures.box is not None:
        yield from _sides(structures.box, view)
    for height in (structures.floor, structures.ceiling) if view.up == VERTICAL else ():
        if height is not None and low[1] <= height <= high[1]:
            yield np.array([[low[0], height], [high[0], height]])


def arrow_in(shape: GateShape, view: View, length: float) -> Floats | None:
    """Tail and tip of a gate's arrow in a view, shape (2, 2) [m]; None where both ways count, or where it points at the reader."""
    arrow = shape.arrow(length)
    if arrow is None:
        return None
    flat = view.project(arrow)
    return flat if np.linalg.norm(flat[1] - flat[0]) >= SEEN * length else None


def arrow_length(shape: GateShape, scale: float, limits: tuple[float, float]) -> float:
    """[m] of a gate's arrow: in proportion to its opening, as far as it can be seen.

    Args:
        shape: the gate.
        scale: units of the drawing per metre.
        limits: the shortest and the longest, in units of the drawing.
    """
    return float(np.clip(0.9 * shape.reach * scale, *limits)) / scale


def _sides(box: Box, view: View) -> Iterator[Floats]:
    """The four sides of a box, cut at the edges of a view."""
    low, high = (np.array(bound)[[view.across, view.up]] for bound in (box.low, box.high))
    outline, (least, most) = Slab(low, high).outline, _edges(view)
    for side in np.stack([outline[:-1], outline[1:]], axis=1):
        cut = np.clip(side, least, most)
        fixed = int(side[0, 0] != side[1, 0])  # the coordinate that does not change along it
        if cut[0, fixed] == side[0, fixed]:
            yield cut


def _edges(view: View) -> tuple[Floats, Floats]:
    """Least and largest coordinates of a view."""
    return np.minimum(view.low, view.high), np.maximum(view.low, view.high)
