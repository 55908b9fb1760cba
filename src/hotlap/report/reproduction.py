"""Pictures of the paper's experiments: maps, matrices, curves with bands, traces and marginals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from hotlap.report.pictures import save
from hotlap.report.style import BEST, FIRST, INK, NORMAL, QUIET, SMALL, headline, place_axes, styled

Floats = NDArray[np.float64]

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#222222")  # Okabe and Ito
SIDE, GAP, LEFT, TOP, BOTTOM = 2.5, 0.75, 0.75, 0.8, 0.55  # inches
SHARES = "viridis"  # of completion, 0 to 1


def draw_maps(
    path: Path,
    axes: tuple[Floats, Floats],
    names: tuple[str, str],
    grids: Sequence[Floats],
    titles: Sequence[str],
    mark: tuple[float, float],
) -> Path:
    """Maps of completion over two parameters, beside each other.

    Args:
        path: of the picture.
        axes: values along x and y.
        names: of both parameters.
        grids: shape (y, x) each, 0 to 1.
        titles: of the maps.
        mark: the default, shown as a cross.

    Raises:
        InputError: when it cannot be written.
    """
    return save(path, _maps(axes, names, grids, titles, mark))


@styled
def _maps(
    axes: tuple[Floats, Floats], names: tuple[str, str], grids: Sequence[Floats], titles: Sequence[str], mark: tuple[float, float]
) -> Figure:
    figure = Figure(figsize=(LEFT + len(grids) * (SIDE + GAP) + 0.35, TOP + SIDE + BOTTOM))
    for k, (grid, title) in enumerate(zip(grids, titles, strict=True)):
        chart = place_axes(figure, LEFT + k * (SIDE + GAP), BOTTOM, SIDE, SIDE)
        image = chart.pcolormesh(*axes, 100 * grid, cmap=SHARES, vmin=0, vmax=100, shading="nearest", rasterized=True)
        chart.plot(*mark, "x", color="white", markersize=6, markeredgewidth=1.4)
        _logarithmic(chart, names)
        chart.set_title(title, fontsize=SMALL, color=QUIET, loc="left")
        if k == len(grids) - 1:
            scale = place_axes(figure, LEFT + k * (SIDE + GAP) + SIDE + 0.1, BOTTOM, 0.1, SIDE)
            figure.colorbar(image, cax=scale).outline.set_visible(False)  # pyright: ignore[reportCallIssue]
    headline(figure, 0.15, f"completion [%] over {names[0]} and {names[1]}", "the cross marks the default values")
    return figure


def _logarithmic(chart: Axes, names: tuple[str, str]) -> None:
    """Make both axes logarithmic, with plain numbers."""
    chart.set_xscale("log")
    chart.set_yscale("log")
    _plain_numbers(chart.xaxis, chart.yaxis)
    chart.set_xlabel(names[0])
    chart.set_ylabel(names[1])


def _plain_numbers(*axes: Axis) -> None:
    """Plain numbers at the ticks of logarithmic axes, also where the range has no power of ten."""
    for axis in axes:
        low, high = axis.get_view_interval()
        axis.set_major_locator(LogLocator(subs=(1, 2, 4) if high < 50 * low else (1,)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def draw_shares(path: Path, rows: Mapping[str, Sequence[Mapping[str, float]]]) -> Path:
    """Share of random parameters that pass every gate over the mean speed of the plan; a line for each race."""
    return save(path, _shares(rows))


@styled
def _shares(rows: Mapping[str, Sequence[Mapping[str, float]]]) -> Figure:
    figure = Figure(figsize=(LEFT + 4.2, TOP + SIDE + BOTTOM))
    chart = place_axes(figure, LEFT, BOTTOM, 3.9, SIDE)
    for (name, own), colour in zip(rows.items(), COLOURS, strict=False):
        chart.plot([row["mean"] for row in own], [100 * row["complete"] for row in own], "o-", color=colour, markersize=3, label=name)
    chart.set_ylim(bottom=0)
    chart.set_xlabel("mean speed of the plan [m/s]")
    chart.set_ylabel("complete [%]")
    chart.grid(visible=True)
    chart.legend(frameon=False, fontsize=SMALL, labelcolor=QUIET)
    headline(figure, 0.15, "random parameters that pass every gate", "even in logarithms within the bounds, one set for all segments")
    return figure


def draw_curves(path: Path, title: str, detail: str, curves: Mapping[str, tuple[Floats, Floats, Floats]], label: str) -> Path:
    """Curves over flights 1, 2, ... with bands.

    Args:
        path: of the picture.
        title: above it.
        detail: below that.
        curves: by name: middle, lower and upper end, each of shape (flights,), in per cent.
        label: of the vertical axis.
    """
    return save(path, _curves(title, detail, curves, label))


@styled
def _curves(title: str, detail: str, curves: Mapping[str, tuple[Floats, Floats, Floats]], label: str) -> Figure:
    figure = Figure(figsize=(LEFT + 7.8, TOP + 3.0 + BOTTOM))
    chart = place_axes(figure, LEFT, BOTTOM, 4.4, 3.0)
    ends = []
    for (name, (middle, low, high)), colour in zip(curves.items(), COLOURS, strict=False):
        flights = np.arange(1, len(middle) + 1)
        chart.fill_between(flights, low, high, color=colour, alpha=0.13, linewidth=0)
        chart.plot(flights, middle, color=colour)
        ends.append((float(middle[-1]), name, colour))
    chart.set_xlim(1, max(len(middle) for middle, _, _ in curves.values()))
    chart.set_ylim(0, 104)
    chart.grid(visible=True, axis="y")
    chart.set_xlabel("flight")
    chart.set_ylabel(label)
    place = 110.0
    for end, name, colour in sorted(ends, reverse=True):
        place = min(end, place - 6.5)
        chart.annotate(name, (1.02, place / 104), xycoords="axes fraction", fontsize=NORMAL, color=colour, va="center")
    headline(figure, 0.15, title, detail)
    return figure


def draw_matrix(path: Path, title: str, detail: str, labels: tuple[Sequence[str], Sequence[str]], shares: Floats) -> Path:
    """A matrix of shares, 0 to 1: a row for each race that was tuned on, a column for each race that was flown."""
    return save(path, _matrix(title, detail, labels, shares))


@styled
def _matrix(title: str, detail: str, labels: tuple[Sequence[str], Sequence[str]], shares: Floats) -> Figure:
    rows, columns = shares.shape
    cell = 0.42
    figure = Figure(figsize=(max(1.5 + columns * cell + 0.3, 4.5), TOP + rows * cell + 0.8))
    chart = place_axes(figure, 1.3, 0.75, columns * cell, rows * cell)
    chart.imshow(100 * shares, cmap=SHARES, vmin=0, vmax=100, aspect="auto")
    for i in range(rows):
        for j in range(columns):
            if np.isfinite(shares[i, j]):
                chart.text(
                    j,
                    i,
                    f"{100 * shares[i, j]:.0f}",
                    ha="center",
                    va="center",
                    fontsize=SMALL,
                    color="white" if shares[i, j] < 0.6 else INK,
                )
    chart.set_xticks(range(columns), labels[1], rotation=40, ha="right")
    chart.set_yticks(range(rows), labels[0])
    chart.set_xlabel("flown")
    chart.set_ylabel("tuned")
    headline(figure, 0.15, title, detail)
    return figure


def draw_traces(path: Path, title: str, detail: str, names: Sequence[str], traces: Sequence[Floats], low: Floats, high: Floats) -> Path:
    """Parameters of the accepted samples over flights, a chart a parameter, a line a run; each trace of shape (flights, K)."""
    return save(path, _traces(title, detail, names, traces, low, high))


@styled
def _traces(title: str, detail: str, names: Sequence[str], traces: Sequence[Floats], low: Floats, high: Floats) -> Figure:
    figure = Figure(figsize=(LEFT + len(names) * (1.9 + GAP), TOP + 1.9 + BOTTOM))
    for k, name in enumerate(names):
        chart = place_axes(figure, LEFT + k * (1.9 + GAP), BOTTOM, 1.9, 1.9)
        for trace in traces:
            chart.plot(np.arange(1, len(trace) + 1), trace[:, k], color=FIRST, linewidth=0.6, alpha=0.7)
            chart.plot(len(trace), trace[-1, k], "o", color=BEST, markersize=3)
        chart.set_yscale("log")
        chart.set_xscale("log")
        chart.set_ylim(low[k], high[k])
        _plain_numbers(chart.xaxis, chart.yaxis)
        chart.set_xlabel("flight")
        chart.set_title(name, fontsize=NORMAL, color=QUIET, loc="left")
    headline(figure, 0.15, title, detail)
    return figure


def draw_marginals(path: Path, title: str, detail: str, names: Sequence[str], samples: Sequence[Floats], low: Floats, high: Floats) -> Path:
    """Histograms of samples in logarithms, a chart a parameter, a line a chain; each chain of shape (samples, K)."""
    return save(path, _marginals(title, detail, names, samples, low, high))


@styled
def _marginals(title: str, detail: str, names: Sequence[str], samples: Sequence[Floats], low: Floats, high: Floats) -> Figure:
    figure = Figure(figsize=(LEFT + len(names) * (1.9 + 0.35), TOP + 1.6 + BOTTOM))
    for k, name in enumerate(names):
        chart = place_axes(figure, LEFT + k * (1.9 + 0.35), BOTTOM, 1.9, 1.6)
        bins = np.geomspace(low[k], high[k], 31)
        for chain, colour in zip(samples, COLOURS, strict=False):
            chart.hist(
                chain[:, k], bins=list(bins), histtype="step", color=colour, density=False, weights=np.full(len(chain), 1 / len(chain))
            )
        chart.set_xscale("log")
        chart.set_xlim(low[k], high[k])
        _plain_numbers(chart.xaxis)
        chart.set_yticks([])
        chart.set_xlabel(name)
    headline(figure, 0.15, title, detail)
    return figure
