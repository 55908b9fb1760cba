"""Views: a scene from above or from the side, drawn to scale with matplotlib."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from hotlap.report.labels import Placer, group, number
from hotlap.report.projection import AXES, Layer, View
from hotlap.report.scene import Scene, Trace
from hotlap.report.silhouettes import arrow_in, arrow_length
from hotlap.report.standing import ARROW, LEAST, draw_structures
from hotlap.report.style import FACE, FAILURE, FIRST, GHOST_DASHES, INK, LINE, QUIET, SMALL, SPEED_MAP, text_width

Floats = NDArray[np.float64]

HEIGHT = 0.105  # inches of a line of size SMALL


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
    axes.plot(*points.T, color="#404040", linewidth=LINE + 1.9, alpha=0.55, solid_capstyle="round", zorder=Layer.FLIGHT_EDGE)
    lines = LineCollection(list(pieces), cmap=SPEED_MAP, norm=norm, linewidth=LINE + 1.1, capstyle="round", zorder=Layer.FLIGHT)
    lines.set_array((speed[:-1] + speed[1:]) / 2)
    axes.add_collection(lines, autolim=False)


def draw_plan(axes: Axes, view: View, scene: Scene, scale: float, *, line: bool) -> None:
    """The plan as a thin line (if `line`), its start, and what stands on the track, to a scale [inches per metre]."""
    path = view.project(scene.path)
    if line:
        axes.plot(*path.T, color=INK, linewidth=0.5, zorder=Layer.PLAN)
    axes.plot(*path[0], marker="s", markersize=4.5, color=FACE, markeredgecolor=INK, markeredgewidth=1.0, zorder=Layer.START)
    draw_structures(axes, view, scene.structures, scale)


def draw_ghost(axes: Axes, view: View, flight: Trace) -> None:
    """A flight for comparison, as a dashed line of one colour."""
    axes.plot(*view.project(flight.position).T, color=FIRST, linewidth=0.9, linestyle=GHOST_DASHES, zorder=Layer.COMPARISON)


def draw_failures(axes: Axes, view: View, positions: Floats, size: float) -> None:
    """Crosses where flights failed; those beyond the drawing are drawn at its edge."""
    points = view.clip(view.project(positions))
    axes.plot(
        *points.T, linestyle="none", marker="x", markersize=size, markeredgewidth=1.3, color=FAILURE, zorder=Layer.FAILURE, clip_on=False
    )


def write_gates(axes: Axes, view: View, scene: Scene, scale: float, placer: Placer) -> None:
    """Write the numbers of the gates beside them, where they cover nothing.

    Args:
        axes: of the view.
        view: from above or from the side.
        scene: that is drawn.
        scale: inches per metre.
        placer: of the labels in this view.
    """
    start, gates = (view.place(view.project(points), scale) for points in (scene.path[:1], scene.gates))
    groups = group(gates, 0.09)
    known = scene.structures.gates
    spots = [(start[0], "start"), *((point, number(known[member].number for member in members)) for point, members in groups)]
    shapes = [known[members[0]].larger(LEAST / scale) for _, members in groups]
    radii = [0.03, *(shape.reach * scale for shape in shapes)]
    for (point, _), radius in zip(spots[1:], radii[1:], strict=True):
        placer.block(point[None], max(0.05, 0.7 * radius))
    placer.block(spots[0][0][None], 0.05)
    for shape in shapes:
        arrow = arrow_in(shape, view, arrow_length(shape, scale, ARROW))
        if arrow is not None:
            placer.block(view.place(arrow[1:], scale), 0.04)
    for i, (point, text) in enumerate(spots):
        place = placer.place(point, text_width(text, SMALL) + 0.06, HEIGHT, gap=0.04 + radii[i])
        x, y = view.low + place * view.signs / scale
        label = axes.text(x, y, text, fontsize=SMALL, ha="center", va="center", color=INK if i else QUIET, zorder=Layer.LABEL)
        label.set_path_effects([withStroke(linewidth=1.8, foreground=FACE)])
