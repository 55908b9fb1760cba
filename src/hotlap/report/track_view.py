"""Track view: a picture of a scene from above and from the side, the flight coloured by speed."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hotlap.core.counts import count
from hotlap.core.success_rate import wilson_interval
from hotlap.report.labels import Placer
from hotlap.report.projection import View, scene_views
from hotlap.report.scene import Scene
from hotlap.report.style import FAILURE, FIRST, INK, QUIET, SMALL, SPEED_MAP, headline, headline_width, place_axes, styled
from hotlap.report.time_charts import draw_bands, draw_gate_times
from hotlap.report.views import (
    draw_failures,
    draw_ghost,
    draw_plan,
    draw_speed,
    frame,
    write_gates,
)

LEFT, RIGHT, TOP, BOTTOM, BETWEEN = 0.62, 0.85, 0.92, 0.5, 0.3  # inches around the drawings
KEY = 0.2  # inches of the line that a plan does not have
WIDTH, MOST_HEIGHT = 6.6, 8.0  # inches of both drawings together
STRIP, STRIP_GAP = 1.15, 0.75  # inches of the chart of speed below a plan


@styled
def track(scene: Scene) -> Figure:
    """The plan, the first flight of a scene coloured by speed, the others as dashed lines, and crosses where flights failed.

    Without a flight, the plan itself is coloured, with its speed over time below.
    """
    views = scene_views(scene)
    scale = min(WIDTH / views[0].extent[0], MOST_HEIGHT / (views[0].extent[1] + views[1].extent[1]))
    width, heights = float(views[0].extent[0]) * scale, [float(view.extent[1]) * scale for view in views]
    bottom = BOTTOM + (0 if scene.traces else STRIP + STRIP_GAP)
    texts = scene.race, _detail(scene), _key(scene)
    full_width = max(LEFT + width + RIGHT, LEFT + headline_width(*texts) + 0.1)
    figure = Figure(figsize=(full_width, bottom + sum(heights) + BETWEEN + TOP - (0 if scene.traces else KEY)))
    norm = Normalize(0.0, _fastest(scene))
    for view, place, height in zip(views, (bottom + heights[1] + BETWEEN, bottom), heights, strict=True):
        _draw(figure, view, scene, (LEFT, place, width, height), scale, norm)
    _colour_bar(figure, LEFT + width + 0.16, bottom, sum(heights) + BETWEEN, norm)
    if not scene.traces:
        _speed_over_time(figure, scene, full_width)
    headline(figure, LEFT, *texts)
    return figure


def _draw(figure: Figure, view: View, scene: Scene, box: tuple[float, float, float, float], scale: float, norm: Normalize) -> None:
    """One view, in a box (left, bottom, width, height) [inches]."""
    axes, above = place_axes(figure, *box), view.up != 2
    side = "" if above else f" (along {'y' if view.across == 0 else 'x'})"
    frame(axes, view, "from above" if above else f"from the side{side}", name_across=not above)
    for ghost in scene.traces[1:]:
        draw_ghost(axes, view, ghost)
    position, speed = scene.coloured_path
    if len(position) > 1:
        draw_speed(axes, view, position, speed, norm)
    draw_plan(axes, view, scene, scale, line=bool(scene.traces))
    for positions, size in zip(scene.failures, (7.0, 4.0, 4.0), strict=False):
        draw_failures(axes, view, positions, size)
    lines = np.vstack([view.place(view.project(line), scale) for line in (scene.path, position)])
    placer = Placer((box[2], box[3]), lines)
    for positions in scene.failures:
        placer.block(view.place(view.project(positions), scale), 0.05)
    write_gates(axes, view, scene, scale, placer)


def _colour_bar(figure: Figure, left: float, bottom: float, height: float, norm: Normalize) -> None:
    """The colour bar of the speed, beside the views."""
    tall = min(height, 2.2)
    axes = place_axes(figure, left, bottom + height - tall, 0.1, tall)
    bar = figure.colorbar(ScalarMappable(norm, SPEED_MAP), cax=axes)
    bar.outline.set_visible(False)  # pyright: ignore[reportCallIssue]
    axes.set_title("m/s", fontsize=SMALL, color=QUIET, loc="left", pad=4)
    bar.locator = MaxNLocator(nbins=6, integer=True)
    bar.update_ticks()
    axes.tick_params(length=2)


def _speed_over_time(figure: Figure, scene: Scene, full_width: float) -> None:
    """The plan's speed with segments and gates, below the views."""
    axes = place_axes(figure, LEFT, BOTTOM - 0.05, full_width - LEFT - 0.3, STRIP)
    speeds = scene.reference.speeds
    axes.set_xlim(0, scene.reference.duration)
    axes.set_ylim(0, 1.3 * float(speeds.max()) + 1e-9)
    draw_bands(axes, scene.segments, full_width - LEFT - 0.3)
    draw_gate_times(axes, scene, full_width - LEFT - 0.3)
    axes.plot(scene.reference.times[: len(speeds)], speeds, color="#333333")
    axes.set_xlabel("time [s]")
    axes.set_ylabel("speed [m/s]")


def _fastest(scene: Scene) -> float:
    """Largest speed of the colour bar [m/s]."""
    speeds = [scene.reference.speeds, *(flight.speed for flight in scene.traces[:1])]
    return max(1.0, float(np.max(np.concatenate(speeds))))


def _detail(scene: Scene) -> str:
    """The line below the title."""
    reference, speeds = scene.reference, scene.reference.speeds
    if not scene.traces:
        return (
            f"plan: {reference.duration:.2f} s to the end, {reference.lap_time:.2f} s to the last of {count(len(scene.gates), 'gate')}, "
            f"up to {speeds.max():.1f} m/s, {speeds.mean():.1f} m/s on average"
        )
    shares = []
    for repeats in scene.repeats:
        if repeats.flights == 1:
            continue  # of which there is no share
        low, high = wilson_interval(repeats.complete, repeats.flights)
        rate = f"{repeats.complete} of {count(repeats.flights, 'flight')} complete"
        shares.append(f"{repeats.label}: {rate} ({100 * low:.0f} to {100 * high:.0f} %)")
    return "; ".join(shares)


def _key(scene: Scene) -> list[tuple[str, str, str]]:
    """Legend of the marks."""
    if not scene.traces:
        return []
    flown, *ghosts = scene.traces
    failed = any(len(positions) for positions in scene.failures)
    return [
        ("━", colormaps[SPEED_MAP].colors[140], f"{flown.label}, {flown.ending}"),  # pyright: ignore[reportAttributeAccessIssue]
        *(("╍╍", FIRST, f"{ghost.label}, {ghost.ending}") for ghost in ghosts),
        ("─", INK, "plan"),
        *[("×", FAILURE, "where failed flights ended" + (f" (small: {ghosts[0].label})" if ghosts else ""))] * failed,
    ]
