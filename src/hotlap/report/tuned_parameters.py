"""Tuned parameters: first guess and best value of each parameter in each segment, within its bounds."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter, NullLocator

from hotlap.report.history import Change
from hotlap.report.style import CLASS_COLOURS, FACE, FAINT, INK, NORMAL, QUIET, SMALL, headline, place_axes, styled

LEFT, RIGHT, TOP, BOTTOM, BETWEEN = 1.25, 0.25, 0.95, 0.5, 0.22  # inches
PANEL, ROW = 1.5, 0.3  # inches


@styled
def tuned_parameters(change: Change, title: str, detail: str = "hollow: first guess; filled: best; log axes from bound to bound") -> Figure:
    """A chart for each parameter with a row for each segment.

    Args:
        change: before and after.
        title: of the figure.
        detail: a line below it.
    """
    count, rows = len(change.names), len(change.segments)
    height = max(1.0, ROW * (rows + 0.6))
    figure = Figure(figsize=(LEFT + count * PANEL + (count - 1) * BETWEEN + RIGHT, BOTTOM + height + TOP))
    for k in range(count):
        axes = place_axes(figure, LEFT + k * (PANEL + BETWEEN), BOTTOM, PANEL, height)
        _draw(axes, change, k)
        if k == 0:
            axes.set_yticks(range(rows), [_name(change, i) for i in range(rows)], fontsize=SMALL)
        else:
            axes.set_yticks([])
    headline(figure, 0.15, title, detail)
    return figure


def _name(change: Change, i: int) -> str:
    """Class and times of a segment; the total time where it has several pieces."""
    pieces = [piece for piece in change.segments.pieces if piece.segment == i]
    times = f"{pieces[0].start:.1f}–{pieces[0].end:.1f} s" if len(pieces) == 1 else f"{sum(p.end - p.start for p in pieces):.1f} s"
    return f"{pieces[0].kind.value}  {times}"


def _draw(axes: Axes, change: Change, k: int) -> None:
    """One parameter in all segments."""
    low, high = float(change.low[k]), float(change.high[k])
    rows = len(change.segments)
    axes.set_xscale("log")
    margin = (high / low) ** 0.03
    axes.set_xlim(low / margin, high * margin)
    axes.set_ylim(rows - 0.4, -0.7)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.axvspan(low, high, color="#f6f6f6", linewidth=0, zorder=0)
    for i, kind in enumerate(change.segments.segment_classes):
        before, after = float(change.before[i, k]), float(change.after[i, k])
        colour = CLASS_COLOURS[kind]
        axes.axhline(i, color=FAINT, linewidth=0.5, zorder=1)
        axes.plot([before, after], [i, i], color=colour, linewidth=2.0, solid_capstyle="butt", zorder=2)
        axes.plot(before, i, marker="o", markersize=4.5, color=FACE, markeredgecolor=QUIET, markeredgewidth=0.9, zorder=3)
        axes.plot(after, i, marker="o", markersize=5.5, color=colour, markeredgecolor=INK, markeredgewidth=0.5, zorder=4)
        _write(axes, after, i, low, high)
    _ticks(axes, low, high)
    axes.set_title(change.names[k], fontsize=NORMAL, loc="left", pad=4)
    if np.ptp(change.before[:, k]) == 0:
        axes.set_title(f"first {change.before[0, k]:.3g}", fontsize=SMALL, color=QUIET, loc="right", pad=4)
    axes.set_xlabel(f"× {change.units[k]}" if change.units[k] else "weight", fontsize=SMALL)


def _write(axes: Axes, value: float, row: int, low: float, high: float) -> None:
    """Write a value above its mark, inside the chart."""
    share = np.log(value / low) / np.log(high / low)
    side = "left" if share < 0.15 else "right" if share > 0.85 else "center"
    axes.text(value, row - 0.17, f"{value:.3g}" if value < 1000 else f"{value:.0f}", fontsize=SMALL - 0.5, ha=side, va="bottom", zorder=5)


def _ticks(axes: Axes, low: float, high: float) -> None:
    """Ticks at the bounds and at powers of ten that are not too close to them; on a short axis, at the middle."""
    powers = [10.0**power for power in range(-6, 7)]
    inner = [power for power in powers if low * 2.5 < power < high / 2.5]
    middle = [] if inner or high < 4 * low else [float(f"{np.sqrt(low * high):.1g}")]
    axes.set_xticks(sorted({low, high, *inner, *middle}))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_minor_locator(NullLocator())
