"""Sample chart: parameters of the search flights, each by itself (histogram) and in pairs (scatter)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator
from numpy.typing import NDArray

from hotlap.core.parameters import ParameterSpace
from hotlap.report.history import Samples, verdicts
from hotlap.report.style import BEST, FACE, FAINT, INK, QUIET, SMALL, headline, place_axes, styled

Floats = NDArray[np.float64]

LEFT, RIGHT, TOP, BOTTOM, BETWEEN, CELL = 0.75, 0.2, 0.95, 0.5, 0.14, 1.3  # inches
BINS = 12


@styled
def samples(found: Samples, space: ParameterSpace, best: Floats, title: str) -> Figure:
    """A triangle of charts: histograms of the parameters on the diagonal, scatter charts of pairs below.

    Where there are several segments, a flight is drawn at the geometric mean of its parameters over the segments.

    Args:
        found: the search flights.
        space: of the parameters.
        best: shape (S, K).
        title: of the figure.
    """
    count, values, marked = space.size, _mean(found.parameters), _mean(best)
    size = count * (CELL + BETWEEN) - BETWEEN
    figure = Figure(figsize=(LEFT + size + RIGHT, BOTTOM + size + TOP))
    for row in range(count):
        for column in range(row + 1):
            axes = place_axes(figure, LEFT + column * (CELL + BETWEEN), BOTTOM + (count - 1 - row) * (CELL + BETWEEN), CELL, CELL)
            _scale(axes, space, column)
            if row == column:
                _draw_marginal(axes, found, values[:, row], space, row)
            else:
                _scale(axes, space, row, up=True)
                _draw_pair(axes, found, values[:, [column, row]], marked[[column, row]])
            _label(axes, space, row, column)
    several = found.parameters.shape[1] > 1
    detail = f"{len(found)} search flights{', mean over segments in logarithms' if several else ''}; axes from bound to bound"
    passed, failed = verdicts(goal=found.goal)
    key = [("●", BEST, passed), ("○", QUIET, failed), ("✚", INK, "tuned: kept")]
    headline(figure, 0.15, title, detail, key)
    return figure


def _mean(parameters: Floats) -> Floats:
    """Geometric mean over segments, (..., S, K) to (..., K)."""
    return np.exp(np.log(parameters).mean(axis=-2))


def _draw_marginal(axes: Axes, found: Samples, values: Floats, space: ParameterSpace, k: int) -> None:
    """Histogram of one parameter over all flights, and over those that met the goal."""
    edges = np.geomspace(space.low[k], space.high[k] * (1 + 1e-9), BINS + 1)
    for some, colour in ((values, FAINT), (values[found.succeeded], BEST)):
        if len(some):
            axes.hist(some, edges, color=colour)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)


def _draw_pair(axes: Axes, found: Samples, values: Floats, best: Floats) -> None:
    """Scatter chart of two parameters."""
    size = 3.0 if len(found) <= 200 else 1.8
    for chosen, face, edge in ((~found.succeeded, FACE, QUIET), (found.succeeded, BEST, BEST)):
        style = {"markersize": size, "markerfacecolor": face, "markeredgecolor": edge, "markeredgewidth": 0.6}
        axes.plot(*values[chosen].T, linestyle="none", marker="o", **style)
    axes.plot(*best, linestyle="none", marker="+", markersize=9, markeredgewidth=1.4, color=INK, zorder=5)


def _scale(axes: Axes, space: ParameterSpace, k: int, *, up: bool = False) -> None:
    """A logarithmic axis from bound to bound, with its bounds as ticks."""
    low, high = float(space.low[k]), float(space.high[k])
    margin = (high / low) ** 0.05
    (axes.set_yscale if up else axes.set_xscale)("log")
    (axes.set_ylim if up else axes.set_xlim)(low / margin, high * margin)
    axis = axes.yaxis if up else axes.xaxis
    axis.set_major_locator(FixedLocator([low, high]))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def _label(axes: Axes, space: ParameterSpace, row: int, column: int) -> None:
    """Names at the edge of the square."""
    last = row == space.size - 1
    axes.tick_params(labelbottom=last, labelleft=column == 0 and row > 0)
    if last:
        axes.set_xlabel(space.names[column], fontsize=SMALL)
    if column == 0 and row > 0:
        axes.set_ylabel(space.names[row], fontsize=SMALL)
    if row == column:
        axes.set_title(space.names[row], fontsize=SMALL, loc="left", pad=3)
