"""What stands on a track, drawn with matplotlib from above or from the side: gates as outlines of their openings, obstacles, box."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, PathPatch, Polygon, Rectangle
from matplotlib.path import Path
from numpy.typing import NDArray

from hotlap.report.projection import Layer, View
from hotlap.report.silhouettes import Disc, arrow_in, arrow_length, borders, silhouette
from hotlap.report.structures import GateShape, Obstacle, Structures, arrow_line
from hotlap.report.style import FACE, INK, QUIET

Floats = NDArray[np.float64]

LEAST = 0.05  # inches from the middle of a gate to its rim, at least
THIN = 0.015  # inches, the least radius of an obstacle
ARROW = (0.11, 0.24)  # inches, the shortest and the longest
DOTTED = (0, (1, 2))
HOLE: Any = {"fill": False, "edgecolor": INK, "linewidth": 0.8, "zorder": Layer.GATE_CIRCLE}
AREA: Any = {"facecolor": INK, "alpha": 0.10, "linewidth": 0, "zorder": Layer.GATE_AREA}
FRAME: Any = {"facecolor": QUIET, "edgecolor": QUIET, "alpha": 0.45, "linewidth": 2.0, "joinstyle": "miter", "zorder": Layer.GATE_AREA}
SOLID: Any = {"facecolor": "#bdbdbd", "edgecolor": QUIET, "linewidth": 0.6, "zorder": Layer.OBSTACLE}


def draw_structures(axes: Axes, view: View, structures: Structures, scale: float) -> None:
    """Gates, points that do not count, obstacles, box, floor and ceiling.

    Args:
        axes: of the view.
        view: from above or from the side.
        structures: to be drawn.
        scale: inches per metre.
    """
    for line in borders(structures, view):
        axes.plot(*line.T, color=QUIET, linewidth=0.9, linestyle=DOTTED, zorder=Layer.BORDER)
    for obstacle in structures.obstacles:
        _draw_obstacle(axes, view, obstacle, THIN / scale)
    for point in view.project(np.array([shape.centre for shape in structures.points]).reshape(-1, 3)):
        axes.plot(*point, marker="D", markersize=3, color=FACE, markeredgecolor=INK, markeredgewidth=0.7, zorder=Layer.GATE_CIRCLE)
    for shape in structures.distinct:
        if shape.counts or not shape.bare:
            _draw_gate(axes, view, shape.larger(LEAST / scale), scale)


def _draw_gate(axes: Axes, view: View, shape: GateShape, scale: float) -> None:
    """A circle, or the outline of an opening with its frame and its direction."""
    if shape.plane is None:
        centre = tuple(view.project(shape.centre[None])[0])
        axes.add_patch(Circle(centre, shape.radius, **AREA))
        axes.add_patch(Circle(centre, shape.radius, **HOLE))
        return
    for outer, inner in zip(shape.frames, shape.rims, strict=False):
        axes.add_patch(PathPatch(_ring(view.project(outer), view.project(inner)), **FRAME))
    for rim in map(view.project, shape.rims):
        axes.add_patch(Polygon(rim, **AREA))
        axes.add_patch(Polygon(rim, **HOLE))
    for wall in map(view.project, shape.walls):
        axes.plot(*wall.T, color=INK, linewidth=0.5, zorder=Layer.GATE_CIRCLE)
    arrow = arrow_in(shape, view, arrow_length(shape, scale, ARROW))
    if arrow is not None:
        axes.plot(*arrow_line(arrow).T, color=INK, linewidth=0.9, solid_capstyle="round", zorder=Layer.GATE_CIRCLE)


def _draw_obstacle(axes: Axes, view: View, obstacle: Obstacle, least: float) -> None:
    """A filled shape, cut at the edges of the view."""
    shape = silhouette(obstacle, view, least)
    if isinstance(shape, Disc):
        axes.add_patch(Circle(tuple(shape.centre), shape.radius, **SOLID))
    else:
        axes.add_patch(Rectangle(tuple(shape.low), *(shape.high - shape.low), **SOLID))


def _ring(outer: Floats, inner: Floats) -> Path:
    """The area between two closed outlines, each shape (n, 2)."""
    return Path.make_compound_path(Path(outer, closed=True), Path(inner[::-1], closed=True))
