"""Sensitivity chart: completion over a factor on each parameter, and the loss of completion segment by segment."""

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
def sensitivity(found: Sensitivity, change: Change, title: str) -> Figure:
    """A column for each parameter: completion when it is multiplied in all segments, and the loss when in one segment alone.

    Args:
        found: results of the flights.
        change: names and segments.
        title: of the figure.
    """
    count, rows = len(change.names), len(change.segments)
    bars = ROW * rows
    figure = Figure(figsize=(LEFT + count * (PANEL + BETWEEN) - BETWEEN + RIGHT, BOTTOM + bars + GAP + CURVES + TOP))
    for k, name in enumerate(change.names):
        left = LEFT + k * (PANEL + BETWEEN)
        upper = place_axes(figure, left, BOTTOM + bars + GAP, PANEL, CURVES)
        _draw_curve(upper, found, k)
        upper.set_title(name, fontsize=NORMAL, loc="left", pad=4)
        lower = place_axes(figure, left, BOTTOM, PANEL, bars)
        _draw_losses(lower, found, change, k)
        for axes in (upper, lower)[: 2 * (k > 0)]:
            axes.tick_params(labelleft=False)
        if k == 0:
            upper.set_ylabel("completion [%]")
    detail = f"upper: multiplied in all segments, within bounds, {found.flights} flights a point; lower: lost when ¼ or 4 times in one"
    key = [("━", BEST, "gates passed"), ("┄", QUIET, "flights that pass all"), ("█", CLASS_COLOURS[change.segments.classes[0]], "loss")]
    headline(figure, 0.15, title, detail, key)
    return figure


def _draw_curve(axes: Axes, found: Sensitivity, k: int) -> None:
    """Completion over the factor on one parameter in all segments."""
    axes.grid(visible=True)
    axes.set_xscale("log")
    axes.axvline(1.0, color=INK, linewidth=0.6)
    axes.plot(found.factors, 100 * found.complete[k], color=QUIET, linewidth=0.9, linestyle=(0, (1, 1.2)))
    axes.plot(found.factors, 100 * found.completion[k], color=BEST, marker="o", markersize=3)
    axes.set_ylim(-4, 106)
    axes.set_yticks([0, 50, 100])
    axes.xaxis.set_major_locator(FixedLocator(list(TICKS)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: TICKS.get(round(value, 4), "")))
    axes.set_xlabel("times the best", fontsize=SMALL)


def _draw_losses(axes: Axes, found: Sensitivity, change: Change, k: int) -> None:
    """Loss of completion when one parameter is changed in one segment alone."""
    kinds = change.segments.segment_classes
    losses, places = 100 * np.maximum(found.by_segment[:, k], 0), np.arange(len(kinds))
    axes.barh(places, losses, height=0.62, color=[CLASS_COLOURS[kind] for kind in kinds])
    axes.set_ylim(len(kinds) - 0.4, -0.6)
    axes.set_xlim(0, max(5.0, 100 * float(found.by_segment.max(initial=0.0))))
    axes.set_yticks(places, [f"{i + 1} {kind}" for i, kind in enumerate(kinds)], fontsize=SMALL)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_color(FAINT)
    axes.set_xlabel("loss [%]", fontsize=SMALL)
