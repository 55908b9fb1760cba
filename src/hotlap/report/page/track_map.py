"""Track map: the plan, a flight coloured by its speed, and where flights failed, as SVG that needs nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.report.labels import group, number
from hotlap.report.markup import element, text
from hotlap.report.scene import Scene

Floats = NDArray[np.float64]

SPEEDS = ("#440154", "#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39", "#fde725")  # viridis, evenly
FAILURE = "#c8102e"
WIDTH, GAP, MARGIN = 640.0, 34.0, 14.0  # of the drawing, between the views, and around each
TALLEST = 460.0  # of a view
LEAST = 3.0  # m: a flat track is a strip, not a line
LETTER = 11.0


def draw_track_map(scene: Scene) -> str:
    """A scene from above and from the side, to one scale; the longer of x and y runs across."""
    low, high = _limits(scene)
    extent = high - low
    across = 0 if extent[0] >= extent[1] else 1
    scale = min((WIDTH - 2 * MARGIN) / extent[across], TALLEST / extent[1 - across])
    parts, top = [], 0.0
    for up, name in ((1 - across, "from above"), (2, "from the side")):
        place = _Place(across, up, low, high, scale, top)
        parts.append(_view(scene, place, name))
        top += place.height + GAP
    words = f"{scene.race} from above and from the side, gates numbered, the flight coloured by its speed"
    box = f"0 0 {WIDTH:g} {top:.0f}"
    return element("svg", "".join(parts), xmlns="http://www.w3.org/2000/svg", viewBox=box, role="img", aria_label=words, class_="map")


class _Place:
    """Where a view lies in the drawing.

    Args:
        across, up: world axes to the right (y: to the left) and up.
        low, high: shape (3,) [m] of what is seen.
        scale: units of the drawing per metre.
        top: of the view.
    """

    def __init__(self, across: int, up: int, low: Floats, high: Floats, scale: float, top: float) -> None:
        self.scale, self.top = scale, top
        self._axes, self._low, self._high = [across, up], low, high
        self._left = (WIDTH - scale * float(high[across] - low[across])) / 2
        self.height = scale * float(high[up] - low[up]) + 2 * MARGIN
        self.title = f"{'xyz'[across]} {'→' if across == 0 else '←'} {high[across] - low[across]:.0f} m, "
        self.title += f"{'xyz'[up]} ↑ {high[up] - low[up]:.0f} m"

    def of(self, points: Floats) -> Floats:
        """World positions, shape (n, 3), in the drawing, shape (n, 2)."""
        across, up = self._axes
        right = points[:, across] - self._low[across] if across == 0 else self._high[across] - points[:, across]
        down = self._high[up] - points[:, up]
        return np.column_stack([self._left + self.scale * right, self.top + GAP - MARGIN + self.scale * down])


def _limits(scene: Scene) -> tuple[Floats, Floats]:
    """The box of plan and gates, each shape (3,) [m]."""
    known = np.vstack([scene.path, scene.gates - scene.distance, scene.gates + scene.distance])
    low, high = known.min(axis=0), known.max(axis=0)
    padding = np.maximum((LEAST - (high - low)) / 2, 0.0)
    return low - padding, high + padding


def _view(scene: Scene, place: _Place, name: str) -> str:
    """One view, back to front."""
    title = element("text", text(f"{name}: {place.title}"), x=MARGIN, y=f"{place.top + LETTER:.1f}", font_size=LETTER, fill="currentColor")
    plan = _line(place.of(scene.path), stroke="currentColor", stroke_width=1, opacity=0.45)
    flown = "".join(_coloured(scene, place))
    return element("g", title + "".join(_gates(scene, place)) + plan + flown + "".join(_failures(scene, place)))


def _coloured(scene: Scene, place: _Place) -> Iterator[str]:
    """The first flight, or the plan where there is none, in pieces of one colour each."""
    replay = scene.traces[0] if scene.traces else None
    position, speed = (scene.path, scene.reference.speeds) if replay is None else (replay.position, replay.speed)
    if len(position) < 2:
        return
    points = place.of(position)
    step = max(1, len(points) // 600)
    points, speed = points[::step], speed[::step]
    kinds = np.clip(speed / max(float(speed.max()), 1e-9) * len(SPEEDS), 0, len(SPEEDS) - 1).astype(int)
    ends = np.append(np.flatnonzero(np.diff(kinds)) + 1, len(points) - 1)
    start = 0
    for end in ends.tolist():
        if end > start:
            yield _line(points[start : end + 1], stroke=SPEEDS[kinds[start]], stroke_width=2.5)
        start = end


def _gates(scene: Scene, place: _Place) -> Iterator[str]:
    """Gates to scale with their numbers."""
    for point, members in group(place.of(scene.gates), 6.0):
        x, y = (f"{value:.1f}" for value in point)
        radius = f"{scene.distance * place.scale:.1f}"
        yield element("circle", cx=x, cy=y, r=radius, fill="currentColor", fill_opacity=0.08, stroke="currentColor", stroke_opacity=0.6)
        label: dict[str, Any] = {"font_size": LETTER, "fill": "currentColor", "text_anchor": "middle"}
        yield element("text", number(members), x=x, y=f"{point[1] - scene.distance * place.scale - 3:.1f}", **label)


def _failures(scene: Scene, place: _Place) -> Iterator[str]:
    """Crosses where flights ended that should not have, as far as that lies in the drawing."""
    ends = [repeats.failures for repeats in scene.repeats if len(repeats.failures)]
    for x, y in place.of(np.vstack(ends)).tolist() if ends else []:
        if 0 <= x <= WIDTH and place.top <= y <= place.top + place.height + GAP:
            yield element("path", d=f"M{x - 3:.1f} {y - 3:.1f}l6 6m0 -6l-6 6", stroke=FAILURE, stroke_width=1.5, fill="none")


def _line(points: Floats, **style: Any) -> str:
    """Points joined, shape (n, 2)."""
    places = " ".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist())
    return element("polyline", points=places, fill="none", stroke_linejoin="round", stroke_linecap="round", **style)
