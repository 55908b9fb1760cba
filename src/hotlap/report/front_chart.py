"""Front chart: lap time against what it stands, for the plans that a search has tried."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from hotlap.report.style import BEST, FIRST, INK, LARGE, QUIET, SMALL, headline, place_axes, styled

LEFT, RIGHT, TOP, BOTTOM = 0.85, 0.55, 0.95, 0.55  # inches
WIDTH, HEIGHT = 6.4, 3.3  # inches of the chart
BEFORE, BEHIND = 0.15, 0.3  # of the range of laps of the front: kept for labels, and for what is slower and stands no more


@dataclass(frozen=True)
class Tried:
    """A plan that a search has tried.

    Attributes:
        lap: [s].
        severity: what it stands: 0 the race as described, 1 all that was asked for, 2 twice as much.
        on_front: whether no faster plan stands as much.
        chosen: whether it is the fastest that stands all that was asked for.
    """

    lap: float
    severity: float
    on_front: bool
    chosen: bool


@styled
def front_chart(tried: Sequence[Tried], title: str, detail: str) -> Figure:
    """Lap time from left to right, what is stood from below to above; the front is a stair, the chosen plan is named.

    Args:
        tried: plans that hold at least without conditions; one or more.
        title: of the figure.
        detail: a line below it.
    """
    figure = Figure(figsize=(LEFT + WIDTH + RIGHT, BOTTOM + HEIGHT + TOP))
    axes = place_axes(figure, LEFT, BOTTOM, WIDTH, HEIGHT)
    axes.grid(visible=True, axis="y")
    stair = sorted((one for one in tried if one.on_front), key=lambda one: one.lap)
    others = [one for one in tried if not one.on_front]
    laps, levels = [one.lap for one in stair], [one.severity for one in stair]
    span = max(laps[-1] - laps[0], 0.02 * laps[0])
    first, last = laps[0] - BEFORE * span, laps[-1] + BEHIND * span
    axes.plot([one.lap for one in others], [one.severity for one in others], "o", color=FIRST, markersize=3.5, alpha=0.6, zorder=2)
    axes.step([*laps, last], [*levels, levels[-1]], where="post", color=BEST, linewidth=1.6, zorder=3)
    for one in stair:
        axes.plot(one.lap, one.severity, "o", color=BEST, markersize=8 if one.chosen else 5, zorder=4, clip_on=False)
        axes.annotate(
            f"{one.lap:.2f} s",
            (one.lap, one.severity),
            xytext=(-7, 4),
            textcoords="offset points",
            ha="right",
            fontsize=LARGE if one.chosen else SMALL,
            weight="bold" if one.chosen else "normal",
            color=INK if one.chosen else QUIET,
            zorder=5,
        )
    axes.axhline(1.0, color=INK, linewidth=0.8, dashes=(4, 3), zorder=1)
    axes.set_xlim(first, last)
    axes.set_ylim(-0.08, max(1.3, max(one.severity for one in tried) + 0.25))
    axes.set_xlabel("lap time [s]")
    axes.set_ylabel("how much of what was asked for it stands")
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:.0f} %"))
    marks = [("●", BEST, "no faster plan stands as much"), *[("●", FIRST, "other plans tried")] * any(one.lap < last for one in others)]
    headline(figure, LEFT, title, detail, marks)
    return figure
