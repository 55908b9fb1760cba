"""Time charts: the tracking error over time, and the parts that all charts over time share."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from hotlap.race.race import GateRule
from hotlap.reference.segmentation import Segments
from hotlap.report.scene import Scene, Trace
from hotlap.report.style import BEST, CLASS_COLOURS, FACE, FAILURE, FIRST, INK, QUIET, SMALL, headline, place_axes, styled, text_width

Floats = NDArray[np.float64]

LEFT, RIGHT, TOP, BOTTOM = 0.62, 1.0, 0.85, 0.5  # inches
WIDTH, HEIGHT = 8.0, 2.6  # inches of the chart
LINE_HEIGHT = 0.14  # inches


def draw_bands(axes: Axes, segments: Segments, width: float) -> None:
    """Segments as coloured bands with their classes at the upper edge, written vertically where a band is narrow.

    Args:
        axes: with the time to the right, its limits set.
        segments: S segments.
        width: inches of the axes.
    """
    low, high = axes.get_xlim()
    transform = axes.get_xaxis_transform()
    for start, end, kind in zip(segments.starts, segments.ends, segments.classes, strict=True):
        axes.axvspan(start, end, color=CLASS_COLOURS[kind], alpha=0.13, linewidth=0, zorder=0)
        axes.axvline(end, color=FACE, linewidth=1.2, zorder=0.5)
        room = (end - start) / (high - low) * width
        lying = room > text_width(kind.value, SMALL) + 0.05
        if room > LINE_HEIGHT:
            axes.text(
                (start + end) / 2,
                0.97,
                kind.value,
                transform=transform,
                rotation=0 if lying else 90,
                fontsize=SMALL,
                color=QUIET,
                ha="center",
                va="top",
            )


def draw_gate_times(axes: Axes, scene: Scene, width: float) -> None:
    """Gates as thin lines, numbered above where there is room."""
    low, high = axes.get_xlim()
    transform, free = axes.get_xaxis_transform(), -np.inf
    for gate, time in zip(scene.structures.gates, scene.reference.gate_times, strict=True):
        axes.axvline(time, color="#b9b9b9", linewidth=0.6, zorder=1)
        place, half = (time - low) / (high - low) * width, text_width(str(gate.number), SMALL) / 2 + 0.03
        if place - half >= free:
            axes.text(time, 1.01, str(gate.number), transform=transform, fontsize=SMALL, color=QUIET, ha="center", va="bottom")
            free = place + half


@styled
def tracking_error(scene: Scene) -> Figure:
    """Distance of each flight from the reference over time, with its judged distance from each gate."""
    figure = Figure(figsize=(LEFT + WIDTH + RIGHT, BOTTOM + HEIGHT + TOP))
    axes, top = place_axes(figure, LEFT, BOTTOM, WIDTH, HEIGHT), _top(scene)
    axes.set_xlim(0, scene.reference.duration)
    axes.set_ylim(0, top)
    draw_bands(axes, scene.segments, WIDTH)
    draw_gate_times(axes, scene, WIDTH)
    by_distance = scene.rule is not GateRule.OPENING
    if by_distance:
        _draw_limit(axes, scene.distance)
    for flight, colour in zip(scene.traces, (BEST, FIRST), strict=False):
        _draw_flight(axes, flight, colour, top, judged=by_distance)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("distance [m]")
    key = [
        ("━", colour, f"{flight.label}: {flight.ending}, {_summary(flight)}")
        for flight, colour in zip(scene.traces, (BEST, FIRST), strict=False)
    ]
    dots = "dots: distance from the gate as it is judged; " if by_distance else ""
    detail = f"line: distance from the reference; {dots}numbers: gates"
    headline(figure, LEFT, f"{scene.race}: tracking error", detail, key)
    return figure


def _top(scene: Scene) -> float:
    """Upper limit of the chart [m]: the first flight fits into it, the others may leave it."""
    distance = max(shape.reach for shape in scene.structures.gates) if scene.rule is GateRule.OPENING else scene.distance
    error = scene.traces[0].error if scene.traces else np.zeros(0)
    return min(max(1.75 * distance, 1.3 * float(error.max(initial=0.0))), 4 * distance)


def _draw_limit(axes: Axes, distance: float) -> None:
    """The distance within which a gate is passed, as a line."""
    axes.axhline(distance, color=INK, linewidth=0.9, linestyle=(0, (5, 2)), zorder=2)
    axes.annotate(
        f"gate passed\nwithin {distance:g} m",
        (1, distance),
        xycoords=("axes fraction", "data"),
        xytext=(5, 0),
        textcoords="offset points",
        fontsize=SMALL,
        va="center",
    )


def _draw_flight(axes: Axes, flight: Trace, colour: str, top: float, *, judged: bool) -> None:
    """Tracking error, distances from the gates where they are judged by it, and end of one flight."""
    front = 4 if colour == BEST else 3
    axes.plot(flight.times, flight.error, color=colour, zorder=front)
    passed = np.arange(len(flight.gate_distance)) < flight.gates_passed
    styles: tuple[dict[str, Any], ...] = ({"color": colour}, {"color": FACE, "markeredgecolor": FAILURE})
    for seen, style in zip((passed, ~passed), styles, strict=True) if judged else ():
        heights = np.where(flight.gate_distance[seen] > top, np.nan, flight.gate_distance[seen])
        axes.plot(flight.seen_times[seen], heights, linestyle="none", marker="o", markersize=3.2, zorder=front + 2, clip_on=False, **style)
    if flight.failed and len(flight.error):
        _draw_end(axes, float(flight.times[-1]), float(flight.error[-1]), top)


def _draw_end(axes: Axes, time: float, error: float, top: float) -> None:
    """A cross where a flight failed; above the limit of the chart it is drawn near the upper edge, with its value."""
    height = min(error, 0.84 * top)  # below the names of the classes
    axes.plot(time, height, marker="x", markersize=7, markeredgewidth=1.5, color=FAILURE, zorder=8, clip_on=False)
    if error > height:
        place = {"xytext": (6, 0), "textcoords": "offset points", "va": "center", "annotation_clip": False}
        label = axes.annotate(f"at {error:.1f} m", (time, height), fontsize=SMALL, color=FAILURE, zorder=8, **place)
        label.set_path_effects([withStroke(linewidth=1.8, foreground=FACE)])


def _summary(flight: Trace) -> str:
    """Mean and largest error."""
    if not len(flight.error):
        return "no record"
    return f"mean {flight.error.mean():.2f} m, max {flight.error.max():.2f} m"
