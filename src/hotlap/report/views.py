"""Views: a scene drawn to scale from above and from the side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.patches import Circle
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from hotlap.report.labels import Placer, group, number
from hotlap.report.scene import Scene, Trace
from hotlap.report.style import FACE, FAILURE, FIRST, GHOST_DASHES, INK, LINE, QUIET, SMALL, SPEED_MAP, text_width

Floats = NDArray[np.float64]

AXES = "xyz"
HEIGHT = 0.105  # inches of a line of size SMALL
LEAST_EXTENT = 3.0  # m: a flat track is a strip, not a line
STRAY = 0.12  # of the extent: how far beyond the plan flights are still shown


@dataclass(frozen=True)
class View:
    """A way to look at a scene, with what there is to see.

    Attributes:
        across, up: which world axes run to the right and up.
        low, high: shape (2,) [m] limits of the drawing; `low[0] > high[0]` where the axis runs to the left.
    """

    across: int
    up: int
    low: Floats
    high: Floats

    @property
    def extent(self) -> Floats:
        """Shape (2,) [m]."""
        return np.abs(self.high - self.low)

    def project(self, points: Floats) -> Floats:
        """World positions as they lie in the drawing, shape (n, 2) [m]."""
        return points[:, [self.across, self.up]]

    def inches(self, points: Floats, scale: float) -> Floats:
        """World positions in inches from the lower left corner, shape (n, 2)."""
        return (self.project(points) - self.low) * np.sign(self.high - self.low) * scale


def from_above_and_aside(scene: Scene) -> tuple[View, View]:
    """Two views of a scene that share the axis to the right: the longer of x and y (y runs to the left where x runs up)."""
    low, high = limits(scene)
    across = 0 if high[0] - low[0] >= high[1] - low[1] else 1
    flip = across == 1
    right = (high[across], low[across]) if flip else (low[across], high[across])
    above, aside = (View(across, up, np.array([right[0], low[up]]), np.array([right[1], high[up]])) for up in (1 - across, 2))
    return above, aside


def limits(scene: Scene) -> tuple[Floats, Floats]:
    """The box to draw, each shape (3,) [m]: the plan with its gates, and flights as far as they do not stray too far."""
    known = np.vstack([scene.path, scene.gates - scene.distance, scene.gates + scene.distance])
    low, high = known.min(axis=0), known.max(axis=0)
    margin = STRAY * float((high - low).max())
    flown = [flight.position for flight in scene.traces] + [repeats.failures for repeats in scene.repeats]
    everything = np.vstack([known, *(np.clip(points, low - margin, high + margin) for points in flown)])
    low, high = everything.min(axis=0), everything.max(axis=0)
    padding = np.maximum(0.03 * float((high - low).max()), (LEAST_EXTENT - (high - low)) / 2)
    return low - padding, high + padding


def frame(axes: Axes, view: View, title: str, *, name_across: bool) -> None:
    """Limits, units and title of a view."""
    axes.set_xlim(view.low[0], view.high[0])
    axes.set_ylim(view.low[1], view.high[1])
    axes.set_ylabel(f"{AXES[view.up]} [m]")
    if name_across:
        axes.set_xlabel(f"{AXES[view.across]} [m]")
    axes.tick_params(labelbottom=name_across)
    axes.grid(visible=True)
    axes.set_title(title, fontsize=SMALL, color=QUIET, loc="left", pad=3)


def draw_speed(axes: Axes, view: View, position: Floats, speed: Floats, norm: Normalize) -> None:
    """A path coloured by speed, on a dark edge that keeps the light end of the map visible."""
    points = view.project(position)
    pieces = np.stack([points[:-1], points[1:]], axis=1)
    axes.plot(*points.T, color="#404040", linewidth=LINE + 1.9, alpha=0.55, solid_capstyle="round", zorder=3)
    lines = LineCollection(list(pieces), cmap=SPEED_MAP, norm=norm, linewidth=LINE + 1.1, capstyle="round", zorder=4)
    lines.set_array((speed[:-1] + speed[1:]) / 2)
    axes.add_collection(lines, autolim=False)


def draw_plan(axes: Axes, view: View, scene: Scene, *, line: bool) -> None:
    """The plan, as a thin line if asked for, its start, and the gates to scale."""
    path = view.project(scene.path)
    if line:
        axes.plot(*path.T, color=INK, linewidth=0.5, zorder=5)
    axes.plot(*path[0], marker="s", markersize=4.5, color=FACE, markeredgecolor=INK, markeredgewidth=1.0, zorder=7)
    for centre in view.project(np.unique(scene.gates, axis=0)):
        axes.add_patch(Circle(tuple(centre), scene.distance, facecolor=INK, alpha=0.10, linewidth=0, zorder=2))
        axes.add_patch(Circle(tuple(centre), scene.distance, fill=False, edgecolor=INK, linewidth=0.8, zorder=6))


def draw_ghost(axes: Axes, view: View, flight: Trace) -> None:
    """A flight for comparison, without speeds."""
    axes.plot(*view.project(flight.position).T, color=FIRST, linewidth=0.9, linestyle=GHOST_DASHES, zorder=2.5)


def draw_failures(axes: Axes, view: View, positions: Floats, size: float) -> None:
    """Where flights ended that should not have; those beyond the drawing stand at its edge."""
    low, high = np.minimum(view.low, view.high), np.maximum(view.low, view.high)
    points = np.clip(view.project(positions), low, high)
    axes.plot(*points.T, linestyle="none", marker="x", markersize=size, markeredgewidth=1.3, color=FAILURE, zorder=8, clip_on=False)


def write_gates(axes: Axes, view: View, scene: Scene, scale: float, placer: Placer) -> None:
    """Numbers beside the gates, as near as they do not hide anything.

    Args:
        axes: of the view.
        view: how it looks at the scene.
        scene: what is drawn.
        scale: inches per metre.
        placer: of the labels in this view.
    """
    spots = [(view.inches(scene.path[:1], scale)[0], "start")]
    spots += [(point, number(members)) for point, members in group(view.inches(scene.gates, scale), 0.09)]
    radius = scene.distance * scale
    placer.block(np.array([point for point, _ in spots[1:]]), max(0.05, 0.7 * radius))
    placer.block(spots[0][0][None], 0.05)
    for i, (point, text) in enumerate(spots):
        place = placer.place(point, text_width(text, SMALL) + 0.06, HEIGHT, gap=0.04 + (radius if i else 0.03))
        x, y = view.low + place * np.sign(view.high - view.low) / scale
        label = axes.text(x, y, text, fontsize=SMALL, ha="center", va="center", color=INK if i else QUIET, zorder=9)
        label.set_path_effects([withStroke(linewidth=1.8, foreground=FACE)])
