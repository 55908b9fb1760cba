"""Static HTML: the part of the page that needs no JavaScript: result, map of the track (SVG) and tables."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.success_rate import Validation, wilson_interval
from hotlap.report.labels import group, number
from hotlap.report.markup import element, facts, paragraph, table, text
from hotlap.report.page.replay import BEST, Replay
from hotlap.report.projection import Layer, View, box_of, scene_views
from hotlap.report.scene import Scene, stage
from hotlap.study.result import Result
from hotlap.study.snapshot import Snapshot
from hotlap.tuning.goal import Quantity

Floats = NDArray[np.float64]

SPEEDS = ("#440154", "#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39", "#fde725")  # viridis, evenly
FAILURE = "#c8102e"
WIDTH, GAP, MARGIN = 640.0, 34.0, 14.0  # of the map, between its views, and around each
TALLEST = 460.0  # of a view
MOST_POINTS = 600  # of a line
LETTER = 11.0


def render_static(snapshot: Snapshot, replay: Replay | None) -> str:
    """The study as HTML without script.

    Args:
        snapshot: of the study.
        replay: the flights of the page; None: nothing was flown again yet.
    """
    scene = stage(snapshot.configuration.scenario) if replay is None else replay.scene
    parts = [
        element("h1", text(title_of(snapshot))),
        paragraph(summary_of(snapshot)),
        _figure(scene),
        element("h2", "Facts"),
        facts(_facts(snapshot)),
        *_tables(snapshot, replay),
        element("h2", "Repeat this study"),
        element("pre", element("code", text(snapshot.command))),
    ]
    return "\n".join(parts)


def title_of(snapshot: Snapshot) -> str:
    """Title of the page: race and tuner."""
    return f"{snapshot.configuration.scenario.race.name}: {snapshot.configuration.tuner}"


def summary_of(snapshot: Snapshot) -> str:
    """The result of the study so far, in one or two sentences."""
    result = snapshot.result
    if result is None:
        return "No flights yet."
    where = "" if snapshot.finished else "The search is still running. "
    return f"{where}{_verdict(result, snapshot)} {_validated(result.validation)}".strip()


def _verdict(result: Result, snapshot: Snapshot) -> str:
    """Whether the goal was confirmed, after how many flights, and how good the best flight is."""
    gates = f"{100 * result.best.completion:.0f} % of the gates"
    lap = f", a lap of {result.best.lap_time:.2f} s" if math.isfinite(result.best.lap_time) else ""
    if snapshot.configuration.settings.goal.quantity is Quantity.NONE:
        return f"{result.flights} flights; the best passed {gates}{lap}."
    if result.best.confirmed:
        flights = "1 search flight" if result.search_flights == 1 else f"{result.search_flights} search flights"
        return f"{result.goal} confirmed after {flights}: {gates}{lap}."
    return f"{result.goal} NOT confirmed in {result.flights} flights; the best so far passed {gates}{lap}."


def _validated(validation: Validation | None) -> str:
    """The success rate in validation flights."""
    return "" if validation is None else f"Success rate in the validation: {share(validation.successes, validation.flights)}."


def share(successes: int, flights: int) -> str:
    """A success rate with its interval: 97 of 100 flights (95 % interval 92 to 99 %)."""
    low, high = wilson_interval(successes, flights)
    return f"{successes} of {flights} flights (95 % interval {100 * low:.0f} to {100 * high:.0f} %)"


def _figure(scene: Scene) -> str:
    """The map with a caption."""
    fastest = float(scene.traces[0].speed.max(initial=0.0)) if scene.traces else scene.reference.max_speed
    what = f"flight with the {scene.traces[0].label} parameters, {scene.traces[0].ending}" if scene.traces else "plan"
    words = f"{what}; colour: speed, from violet (0 m/s) to yellow ({fastest:.1f} m/s); circles: gates, radius {scene.distance:g} m"
    crosses = "; red crosses: where failed flights ended" if any(len(positions) for positions in scene.failures) else ""
    return element("figure", draw_track_map(scene) + element("figcaption", text(words + crosses)))


def _facts(snapshot: Snapshot) -> dict[str, object]:
    """Settings and results as a list of facts."""
    asked, result = snapshot.configuration, snapshot.result
    race, settings = asked.scenario.race, asked.settings
    return {
        "race": race.name,
        "vehicle": race.vehicle.name,
        "model in the controller": race.control_model.name,
        "planned lap time": f"{asked.scenario.reference.lap_time:.2f} s",
        "goal": str(settings.goal),
        "seed": settings.seed,
        "flights": "" if result is None else f"{result.flights} of at most {settings.budget}, re-flights included",
        "wall time": "" if result is None else f"{result.wall_time:.1f} s",
        "remark": "" if result is None else result.remark,
        "world": asked.world,
        "fingerprint": asked.fingerprint,
    }


def _tables(snapshot: Snapshot, replay: Replay | None) -> Iterator[str]:
    """Tables: parameters, success rates, and robustness."""
    yield element("h2", "Tuned parameters") + _parameters(snapshot)
    if replay is None:
        return
    yield element("h2", "Flights that passed every gate") + table(
        ("parameters", "flights", "passed every gate"),
        [(repeats.label, repeats.flights, share(repeats.complete, repeats.flights)) for repeats in replay.scene.repeats],
        numbers=(1,),
    )
    if replay.robustness:
        rows = [(one.change, share(one.validation.successes, one.validation.flights)) for one in replay.robustness]
        yield element("h2", "Robustness: the tuned parameters with a changed vehicle") + table(("change", "success rate"), rows)


def _parameters(snapshot: Snapshot) -> str:
    """First guess and best value of each parameter in each segment."""
    asked = snapshot.configuration
    first, best, kinds = asked.first_guess, snapshot.best, asked.scenario.segments.segment_classes
    rows = []
    for i, kind in enumerate(kinds):
        changes = (f"{a:.3g} → {b:.3g}" for a, b in zip(first[i].tolist(), best[i].tolist(), strict=True))
        rows.append((f"{i + 1} {kind}", *changes))
    return table(("segment", *asked.scenario.space.names), rows, f"first guess → {BEST}")


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
        right, up = self.view.place(self.view.clip(self.view.project(points)), self.scale).T
        left, bottom = (WIDTH - self.scale * self.view.extent[0]) / 2, self.top + GAP + self.height - 3 * MARGIN
        return np.column_stack([left + right, bottom - up])


def _draw_view(scene: Scene, panel: _Panel) -> str:
    """One view with its title."""
    parts = {
        Layer.GATE_AREA: _circles(scene, panel, fill="currentColor", fill_opacity=0.08),
        Layer.FLIGHT: "".join(_coloured(scene, panel)),
        Layer.PLAN: _line(panel.of(scene.path), stroke="currentColor", stroke_width=0.8) if scene.traces else "",
        Layer.GATE_CIRCLE: _circles(scene, panel, fill="none", stroke="currentColor", stroke_opacity=0.6),
        Layer.FAILURE: "".join(_crosses(scene, panel)),
        Layer.LABEL: "".join(_gate_numbers(scene, panel)),
    }
    low, high = box_of(np.vstack([scene.path, scene.gates]))
    title = text(panel.view.title(high - low))
    head = element("text", title, x=MARGIN, y=f"{panel.top + LETTER:.1f}", font_size=LETTER, fill="currentColor")
    return element("g", head + "".join(parts[layer] for layer in sorted(parts)))


def _circles(scene: Scene, panel: _Panel, **style: Any) -> str:
    """Gates to scale, those in one place once."""
    radius = f"{scene.distance * panel.scale:.1f}"
    points = panel.of(np.unique(scene.gates, axis=0)).tolist()
    return "".join(element("circle", cx=f"{x:.1f}", cy=f"{y:.1f}", r=radius, **style) for x, y in points)


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
        yield element("text", number(members), x=f"{x:.1f}", y=f"{y - scene.distance * panel.scale - 3:.1f}", **style)


def _line(points: Floats, **style: Any) -> str:
    """A line through points, shape (n, 2)."""
    places = " ".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist())
    return element("polyline", points=places, fill="none", stroke_linejoin="round", stroke_linecap="round", **style)
