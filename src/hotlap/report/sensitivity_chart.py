"""Sensitivity chart: completion over a factor on each parameter, and the loss of it segment by segment; cost where that tells nothing."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from hotlap.analysis.sensitivity import Sensitivity
from hotlap.report.history import Change
from hotlap.report.style import BEST, CLASS_COLOURS, FAINT, INK, NORMAL, QUIET, SMALL, headline, place_axes, styled

LEFT, RIGHT, TOP, BOTTOM, BETWEEN, GAP = 1.05, 0.2, 0.95, 0.5, 0.2, 0.62  # inches
PANEL, CURVES, ROW = 1.5, 1.5, 0.24  # inches
TICKS = {0.25: "¼", 0.5: "½", 1.0: "1", 2.0: "2", 4.0: "4"}


@styled
def sensitivity(found: Sensitivity, change: Change, title: str, cost_name: str = "cost") -> Figure:
    """A column for each parameter: completion when it is multiplied in all segments, and the loss when in one segment alone.

    Where completion is the same whatever is changed, both are the cost, as on the page of the study.

    Args:
        found: results of the flights.
        change: names and segments.
        title: of the figure.
        cost_name: with its unit.
    """
    count, rows = len(change.names), len(change.segments)
    bars = ROW * rows
    figure = Figure(figsize=(LEFT + count * (PANEL + BETWEEN) - BETWEEN + RIGHT, BOTTOM + bars + GAP + CURVES + TOP))
    for k, name in enumerate(change.names):
        left = LEFT + k * (PANEL + BETWEEN)
        upper = place_axes(figure, left, BOTTOM + bars + GAP, PANEL, CURVES)
        (_draw_cost if found.cost_tells else _draw_curve)(upper, found, k)
        upper.set_title(name, fontsize=NORMAL, loc="left", pad=4)
        lower = place_axes(figure, left, BOTTOM, PANEL, bars)
        _draw_losses(lower, found, change, k, cost_name)
        for axes in (upper, lower)[: 2 * (k > 0)]:
            axes.tick_params(labelleft=False)
        if k == 0:
            upper.set_ylabel(cost_name if found.cost_tells else "completion [%]")
    added, what = found.cost_tells_by_segment, "cost added" if found.cost_tells_by_segment else "lost"
    detail = f"upper: multiplied in all segments, within bounds, {found.flights} flights a point; lower: {what} when ¼ or 4 times in one"
    curves = [("━", BEST, "gates passed"), ("┄", QUIET, "flights that pass all")]
    if found.cost_tells:
        curves = [("━", BEST, f"cost; completion stays at {100 * found.completion.flat[0]:.0f} %")]
    bars = ("█", CLASS_COLOURS[change.segments.classes[0]], "rise" if added else "loss")
    headline(figure, 0.15, title, detail, [*curves, bars])
    return figure


def _draw_cost(axes: Axes, found: Sensitivity, k: int) -> None:
    """Cost over the factor on one parameter in all segments."""
    _draw_factors(axes)
    axes.plot(found.factors, np.where(np.isfinite(found.cost[k]), found.cost[k], np.nan), color=BEST, marker="o", markersize=3)
    known = found.cost[np.isfinite(found.cost)]
    beyond = max(0.05 * float(np.ptp(known)), 0.01 * float(np.abs(known).max()), 1e-9)
    axes.set_ylim(known.min() - beyond, known.max() + beyond)


def _draw_curve(axes: Axes, found: Sensitivity, k: int) -> None:
    """Completion over the factor on one parameter in all segments."""
    _draw_factors(axes)
    axes.plot(found.factors, 100 * found.complete[k], color=QUIET, linewidth=0.9, linestyle=(0, (1, 1.2)))
    axes.plot(found.factors, 100 * found.completion[k], color=BEST, marker="o", markersize=3)
    axes.set_ylim(-4, 106)
    axes.set_yticks([0, 50, 100])


def _draw_factors(axes: Axes) -> None:
    """The axis of factors."""
    axes.grid(visible=True)
    axes.set_xscale("log")
    axes.axvline(1.0, color=INK, linewidth=0.6)
    axes.xaxis.set_major_locator(FixedLocator(list(TICKS)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: TICKS.get(round(value, 4), "")))
    axes.set_xlabel("times the best", fontsize=SMALL)


def _draw_losses(axes: Axes, found: Sensitivity, change: Change, k: int, cost_name: str) -> None:
    """Loss of completion, or rise of the cost, when one parameter is changed in one segment alone."""
    kinds, added = change.segments.segment_classes, found.cost_tells_by_segment
    table, least = (found.cost_by_segment, 1e-9) if added else (100 * found.by_segment, 5.0)
    table = np.maximum(np.where(np.isfinite(table), table, 0.0), 0.0)
    losses, places = table[:, k], np.arange(len(kinds))
    axes.barh(places, losses, height=0.62, color=[CLASS_COLOURS[kind] for kind in kinds])
    axes.set_ylim(len(kinds) - 0.4, -0.6)
    axes.set_xlim(0, max(least, float(table.max(initial=0.0))))
    axes.set_yticks(places, [f"{i + 1} {kind}" for i, kind in enumerate(kinds)], fontsize=SMALL)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_color(FAINT)
    axes.set_xlabel(f"{cost_name}, rise" if added else "loss [%]", fontsize=SMALL)
