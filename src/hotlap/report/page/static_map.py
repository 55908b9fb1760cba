"""Static map: a scene from above and from the side as SVG, for readers without JavaScript or without WebGL."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.report.labels import group, number
from hotlap.report.markup import element, text
from hotlap.report.projection import Layer, View, box_of, scene_views
from hotlap.report.scene import Scene
from hotlap.report.silhouettes import Disc, Slab, arrow_in, arrow_length, borders, silhouette
from hotlap.report.structures import GateShape, arrow_line

Floats = NDArray[np.float64]

SPEEDS = ("#440154", "#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39", "#fde725")  # viridis, evenly
FAILURE = "#c8102e"
WIDTH, GAP, MARGIN = 640.0, 34.0, 14.0  # of the map, between its views, and around each
TALLEST = 460.0  # of a view
MOST_POINTS = 600  # of a line
LETTER = 11.0
LEAST = 5.0  # from the middle of a gate to its rim, at least
THIN = 1.5  # the least radius of an obstacle
ARROW = (11.0, 24.0)  # the shortest and the longest


def draw_track_map(scene: Scene) -> str:
    """A scene from above and from the side, to one scale, as SVG."""
    above, side = scene_views(scene)
    scale = float(min((WIDTH - 2 * MARGIN) / above.extent[0], TALLEST / above.extent[1]))
    parts, top = [], 0.0
    for view in (above, side):
        panel = _Panel(view, scale, top)
        parts.append(_draw_view(scene, panel))
        top += panel.height + GAP
    words = f"{scene.race} from above and from the side, gates numbered, the flight coloured by its speed"
    box = f"0 0 {WIDTH:g} {top:.0f}"
    return element("svg", "".join(parts), xmlns="http://www.w3.org/2000/svg", viewBox=box, role="img", aria_label=words, class_="map")


@dataclass(frozen=True)
class _Panel:
    """One view on the map.

    Attributes:
        view: from above or from the side.
        scale: units of the map per metre.
        top: of the panel on the map.
    """

    view: View
    scale: float
    top: float

    @property
    def height(self) -> float:
        """Of the view with its margins."""
        return self.scale * float(self.view.extent[1]) + 2 * MARGIN

    def of(self, points: Floats) -> Floats:
        """World positions on the map, shape (n, 3) to (n, 2); those beyond the view are moved to its edge."""
        return self.place(self.view.clip(self.view.project(points)))

    def place(self, points: Floats) -> Floats:
        """Projected positions on the map, shape (n, 2)."""
        right, up = self.view.place(points, self.scale).T
        left, bottom = self.corner
        return np.column_stack([left + right, bottom - up])

    @property
    def corner(self) -> tuple[float, float]:
        """The lower left corner of the view on the map."""
        return (WIDTH - self.scale * float(self.view.extent[0])) / 2, self.top + GAP + self.height - 3 * MARGIN


def _draw_view(scene: Scene, panel: _Panel) -> str:
    """One view with its title."""
    parts = {
        Layer.BORDER: "".join(_behind(scene, panel)),
        Layer.GATE_AREA: _circles(scene, panel, fill="currentColor", fill_opacity=0.08) + "".join(_openings(scene, panel)),
        Layer.FLIGHT: "".join(_coloured(scene, panel)),
        Layer.PLAN: _line(panel.of(scene.path), stroke="currentColor", stroke_width=0.8) if scene.traces else "",
        Layer.GATE_CIRCLE: _circles(scene, panel, fill="none", stroke="currentColor", stroke_opacity=0.6) + "".join(_rims(scene, panel)),
        Layer.FAILURE: "".join(_crosses(scene, panel)),
        Layer.LABEL: "".join(_gate_numbers(scene, panel)),
    }
    low, high = scene.structures.surround(*box_of(np.vstack([scene.path, scene.gates])))
    title = text(panel.view.title(high - low))
    head = element("text", title, x=MARGIN, y=f"{panel.top + LETTER:.1f}", font_size=LETTER, fill="currentColor")
    return element("g", head + "".join(parts[layer] for layer in sorted(parts)))


def _circles(scene: Scene, panel: _Panel, **style: Any) -> str:
    """Gates without an orientation, to scale, those in one place once."""
    round_ones = [shape.larger(LEAST / panel.scale) for shape in scene.structures.distinct if shape.plane is None and shape.counts]
    points = panel.of(np.array([shape.centre for shape in round_ones]).reshape(-1, 3)).tolist()
    radii = [f"{shape.radius * panel.scale:.1f}" for shape in round_ones]
    return "".join(element("circle", cx=f"{x:.1f}", cy=f"{y:.1f}", r=r, **style) for (x, y), r in zip(points, radii, strict=True))


def _behind(scene: Scene, panel: _Panel) -> Iterator[str]:
    """Obstacles, cut at the edges of the view, and the lines of box, floor and ceiling."""
    left, bottom = panel.corner
    width, height = (panel.view.extent * panel.scale).tolist()
    shapes = "".join(_obstacle(silhouette(obstacle, panel.view, THIN / panel.scale), panel) for obstacle in scene.structures.obstacles)
    if shapes:
        box = {"x": f"{left:.1f}", "y": f"{bottom - height:.1f}", "width": f"{width:.1f}", "height": f"{height:.1f}"}
        yield element("svg", shapes, **box, viewBox=" ".join(box.values()), class_="obstacles")
    for line in borders(scene.structures, panel.view):
        yield _line(panel.place(line), stroke="currentColor", stroke_opacity=0.6, stroke_dasharray="1 2")


def _obstacle(shape: Disc | Slab, panel: _Panel) -> str:
    """A grey shape."""
    style = {"fill": "currentColor", "fill_opacity": 0.3, "stroke": "currentColor", "stroke_opacity": 0.6, "stroke_width": 0.6}
    if isinstance(shape, Slab):
        return _polygon(panel.place(shape.outline[:-1]), **style)
    ((x, y),) = panel.place(shape.centre[None]).tolist()
    return element("circle", cx=f"{x:.1f}", cy=f"{y:.1f}", r=f"{shape.radius * panel.scale:.1f}", **style)


def _openings(scene: Scene, panel: _Panel) -> Iterator[str]:
    """Openings as areas, with their frames around them."""
    for shape in scene.structures.distinct:
        shown = shape.larger(LEAST / panel.scale)
        for outer, inner in zip(shown.frames, shown.rims, strict=False):
            ring = " ".join("M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in panel.of(line[:-1]).tolist()) + "Z" for line in (outer, inner))
            style = {"fill": "currentColor", "fill_rule": "evenodd", "stroke": "currentColor", "stroke_width": 2.5, "opacity": 0.35}
            yield element("path", d=ring, **style)
        for rim in shown.rims:
            yield _polygon(panel.of(rim[:-1]), fill="currentColor", fill_opacity=0.08)


def _rims(scene: Scene, panel: _Panel) -> Iterator[str]:
    """Rims of the openings, walls of tunnels, and arrows along the way in which gates are passed."""
    for shape in scene.structures.distinct:
        shown = shape.larger(LEAST / panel.scale)
        for rim in shown.rims:
            yield _polygon(panel.of(rim[:-1]), fill="none", stroke="currentColor", stroke_width=1.2)
        for wall in shown.walls:
            yield _line(panel.of(wall), stroke="currentColor", stroke_width=0.6)
        arrow = arrow_in(shown, panel.view, arrow_length(shown, panel.scale, ARROW))
        if arrow is not None:
            yield _line(arrow_line(panel.place(arrow)), stroke="currentColor", stroke_width=1.2, class_="way")
    for point in scene.structures.points:
        ((x, y),) = panel.of(point.centre[None]).tolist()
        yield element("path", d=f"M{x - 3:.1f} {y:.1f}h6m-3 -3v6", stroke="currentColor", stroke_opacity=0.6, fill="none")


def _coloured(scene: Scene, panel: _Panel) -> Iterator[str]:
    """The first flight, or the plan where there is none, as one line for each run of rows of the same colour."""
    position, speed = scene.coloured_path
    if len(position) < 2:
        return
    step = max(1, len(position) // MOST_POINTS)
    points, speed = panel.of(position[::step]), speed[::step]
    colours = np.clip(speed / max(float(speed.max()), 1e-9) * len(SPEEDS), 0, len(SPEEDS) - 1).astype(int)
    ends = np.append(np.flatnonzero(np.diff(colours)) + 1, len(points) - 1)
    start = 0
    for end in ends.tolist():
        if end > start:
            yield _line(points[start : end + 1], stroke=SPEEDS[colours[start]], stroke_width=2.5)
        start = end


def _crosses(scene: Scene, panel: _Panel) -> Iterator[str]:
    """Crosses where flights failed."""
    for x, y in panel.of(np.vstack([np.zeros((0, 3)), *scene.failures])).tolist():
        yield element("path", d=f"M{x - 3:.1f} {y - 3:.1f}l6 6m0 -6l-6 6", stroke=FAILURE, stroke_width=1.5, fill="none")


def _gate_numbers(scene: Scene, panel: _Panel) -> Iterator[str]:
    """Numbers above the gates; gates that are drawn in one place share a label."""
    style: dict[str, Any] = {"font_size": LETTER, "fill": "currentColor", "text_anchor": "middle"}
    for (x, y), members in group(panel.of(scene.gates), 6.0):
        above = _top(scene.structures.gates[members[0]].larger(LEAST / panel.scale), panel)
        numbers = number(scene.structures.gates[member].number for member in members)
        yield element("text", numbers, x=f"{x:.1f}", y=f"{y - above - 3:.1f}", **style)


def _top(shape: GateShape, panel: _Panel) -> float:
    """How far a gate and its arrow reach up from its centre."""
    arrow = arrow_in(shape, panel.view, arrow_length(shape, panel.scale, ARROW))
    tip = 0.0 if arrow is None else float(arrow[1, 1] - arrow[0, 1])
    return panel.scale * max(tip, float(shape.bounds[1, panel.view.up] - shape.centre[panel.view.up]))


def _polygon(points: Floats, **style: Any) -> str:
    """A closed line through points, shape (n, 2)."""
    return element("polygon", points=" ".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist()), **style)


def _line(points: Floats, **style: Any) -> str:
    """A line through points, shape (n, 2)."""
    places = " ".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist())
    return element("polyline", points=places, fill="none", stroke_linejoin="round", stroke_linecap="round", **style)
