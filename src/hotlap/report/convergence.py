"""Convergence: completion and cost of every flight of a search, and of the best flight so far."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullFormatter
from numpy.typing import NDArray

from hotlap.report.history import History, verdicts
from hotlap.report.style import AGAIN, BEST, FACE, FAILURE, INK, SMALL, headline, place_axes, styled

Floats = NDArray[np.float64]

LEFT, RIGHT, TOP, BOTTOM, BETWEEN = 0.62, 0.9, 0.85, 0.5, 0.22  # inches
WIDTH, HEIGHT = 7.0, 1.75  # inches of each chart


@styled
def convergence(history: History, title: str, detail: str = "") -> Figure:
    """Two charts over the number of flights: completion above, cost below.

    Args:
        history: the flights.
        title: of the figure.
        detail: a line below it.
    """
    figure = Figure(figsize=(LEFT + WIDTH + RIGHT, BOTTOM + 2 * HEIGHT + BETWEEN + TOP))
    lower = place_axes(figure, LEFT, BOTTOM, WIDTH, HEIGHT)
    upper = place_axes(figure, LEFT, BOTTOM + HEIGHT + BETWEEN, WIDTH, HEIGHT, sharex=lower)
    _draw(upper, history, 100 * history.completion, 100 * history.best_completion)
    _draw(lower, history, history.cost, history.best_cost)
    upper.set_ylim(-4, 108)
    upper.set_yticks([0, 25, 50, 75, 100])
    upper.set_ylabel("completion [%]")
    upper.tick_params(labelbottom=False)
    lower.set_ylabel(history.cost_name)
    lower.set_xlabel("flights")
    last = int(history.numbers.max(initial=1))
    lower.set_xlim(0.5 - 0.02 * last, last + 0.5 + 0.01 * last)
    lower.xaxis.set_major_locator(MaxNLocator(integer=True, nbins=10, steps=[1, 2, 5, 10]))
    _scale_cost(lower, history.cost[np.isfinite(history.cost)])
    headline(figure, LEFT, title, detail, _key(history))
    return figure


def _draw(axes: Axes, history: History, values: Floats, best: Floats) -> None:
    """One chart: a mark for each flight, a line for the best so far."""
    axes.grid(visible=True, axis="y")
    x, seen = history.numbers, np.isfinite(values)
    search, again = history.searching & seen, ~history.searching & seen
    size = 4.5 if len(history) <= 80 else 3.2
    for chosen, face in ((search & history.failed, FACE), (search & ~history.failed, BEST)):
        _mark(axes, x[chosen], values[chosen], marker="o", markersize=size, markerfacecolor=face, markeredgecolor=BEST)
    good, bad = again & ~history.failed, again & history.failed
    _mark(axes, x[good], values[good], marker="D", markersize=size - 0.5, color=AGAIN, markeredgecolor=INK, markeredgewidth=0.4)
    _mark(axes, x[bad], values[bad], marker="x", markersize=size + 1, color=FAILURE, markeredgewidth=1.4)
    kept = search & history.tuned
    _mark(axes, x[kept], values[kept], marker="o", markersize=size + 5, markerfacecolor="none", markeredgecolor=INK, markeredgewidth=1.3)
    axes.step(x, best, where="post", color=INK, linewidth=1.0, zorder=2)
    known = np.flatnonzero(np.isfinite(best))
    if len(known):
        axes.annotate(
            "best search\nflight so far",
            (float(x[-1]), float(best[known[-1]])),
            xytext=(10, 0),
            textcoords="offset points",
            fontsize=SMALL,
            va="center",
            annotation_clip=False,
        )


def _mark(axes: Axes, x: NDArray[np.int64], y: Floats, **style: object) -> None:
    axes.plot(x, y, linestyle="none", zorder=3, clip_on=False, **{"markeredgewidth": 0.9, **style})


def _scale_cost(axes: Axes, cost: Floats) -> None:
    """Make the axis of the cost logarithmic where the costs differ by more than a factor of 3."""
    if not len(cost) or cost.min() <= 0 or cost.max() < 3 * cost.min():
        return
    axes.set_yscale("log")
    axes.set_ylim(cost.min() / 1.25, cost.max() * 1.25)
    ticks = [base * 10.0**power for power in range(-3, 6) for base in (1, 2, 5)]
    axes.set_yticks([tick for tick in ticks if cost.min() / 1.25 <= tick <= cost.max() * 1.25])
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _key(history: History) -> list[tuple[str, str, str]]:
    """Legend of the marks that occur."""
    search, again, (passed, failed) = history.searching, ~history.searching, verdicts(goal=history.goal)
    return [
        *[("●", BEST, passed)] * bool((search & ~history.failed).any()),
        *[("○", BEST, failed)] * bool((search & history.failed).any()),
        *[("◎", INK, "tuned: kept")] * bool((search & history.tuned).any()),
        *[("◆", AGAIN, "re-flight passed")] * bool((again & ~history.failed).any()),
        *[("×", FAILURE, "re-flight failed")] * bool((again & history.failed).any()),
    ]
