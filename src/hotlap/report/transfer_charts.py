"""Charts of a transfer: the tracking error of the same parameters in several worlds, as boxes and over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hotlap.analysis.transfer import DEFAULT, STARTING, TUNED, TransferRow, metres
from hotlap.report.pictures import save
from hotlap.report.style import AGAIN, BEST, FAILURE, FIRST, INK, NORMAL, QUIET, SMALL, headline, headline_width, place_axes, styled

Floats = NDArray[np.float64]

BOXES, OVER_TIME = "error_boxes.png", "error_over_time.png"
COLOURS: Mapping[str, str] = {DEFAULT: FIRST, TUNED: BEST}
LEFT, RIGHT, TOP, BOTTOM = 0.7, 0.25, 0.85, 0.55  # inches
PAIR, FURTHER, BOX_HEIGHT, BOX_WIDTH = 1.5, 1.3, 2.8, 0.5  # inches a world, and for each set beyond two; inches; of two boxes' distance
LONG, TALL, GAP = 7.2, 1.5, 0.32  # inches of a chart over time, and between two
REACH = 3.0  # times the largest error of all flights that passed every gate: as far as the charts reach


def draw_transfer(folder: Path, race: str, rows: Sequence[TransferRow], prefix: str = "") -> tuple[Path, Path]:
    """Draw both charts.

    Args:
        folder: for the pictures.
        race: its name.
        rows: of all worlds.
        prefix: of the names of the files.

    Returns:
        The files.

    Raises:
        InputError: when one cannot be written.
    """
    return save(folder / f"{prefix}{BOXES}", error_boxes(race, rows)), save(folder / f"{prefix}{OVER_TIME}", error_over_time(race, rows))


@styled
def error_boxes(race: str, rows: Sequence[TransferRow]) -> Figure:
    """Tracking error of all control steps of all flights: a box for each set of parameters in each world."""
    names, labels = _worlds(rows), _labels(rows)
    title = f"{race}: tracking error"
    detail = f"all control steps; box: quartiles and median, whiskers: 5 and 95 %, triangle: largest after {STARTING:g} s"
    width = max(len(names) * (PAIR + FURTHER * max(len(labels) - 2, 0)), headline_width(title, detail, _key(labels)))
    figure = Figure(figsize=(LEFT + width + RIGHT, TOP + BOX_HEIGHT + BOTTOM))
    axes = place_axes(figure, LEFT, BOTTOM, width, BOX_HEIGHT)
    axes.grid(visible=True, axis="y")
    top = _top(rows)
    axes.set_ylim(0, top)
    axes.set_xlim(-0.5, len(names) - 0.5)
    for row in rows:
        beside = (labels.index(row.label) - (len(labels) - 1) / 2) / (len(labels) + 1)
        _draw_box(axes, row, names.index(row.world) + beside, BOX_WIDTH / (len(labels) + 1), top, right=beside >= 0)
    axes.set_xticks(range(len(names)), [_passed(rows, name) for name in names])
    axes.tick_params(axis="x", length=0, labelsize=NORMAL)
    axes.set_ylabel("distance from the reference [m]")
    headline(figure, LEFT, title, detail, _key(labels))
    return figure


def _draw_box(axes: Axes, row: TransferRow, place: float, width: float, top: float, *, right: bool) -> None:
    """One box, with its median to its left or right; a largest error above the chart is written at its upper edge."""
    errors, colour = row.errors, _colour(row.label)
    if not len(errors):
        axes.plot(place, 0, marker="x", color=FAILURE, clip_on=False)
        return
    low, lower, middle, upper, high = np.percentile(errors, [5, 25, 50, 75, 95])
    box = {"med": middle, "q1": lower, "q3": upper, "whislo": low, "whishi": high, "fliers": []}
    line = {"color": colour, "linewidth": 1.1}
    axes.bxp(
        [box],
        positions=[place],
        widths=[width],
        showfliers=False,
        patch_artist=True,
        manage_ticks=False,
        boxprops={"facecolor": colour, "alpha": 0.3, "edgecolor": colour},
        medianprops={"color": colour, "linewidth": 1.8},
        whiskerprops=line,
        capprops=line,
    )
    at, shift, side = (place + width / 2, 3, "left") if right else (place - width / 2, -3, "right")
    told, height = (metres(middle), middle) if middle <= top else (f"median\n{metres(middle)}", 0.92 * top)
    axes.annotate(told, (at, height), (shift, 0), textcoords="offset points", fontsize=SMALL, color=INK, va="center", ha=side)
    largest = max(flight.later_error for flight in row.flights if len(flight.errors))
    axes.plot(place, min(largest, 0.98 * top), marker="^", markersize=4, color=colour, clip_on=False)
    if largest > top:
        axes.annotate(metres(largest), (place, top), (0, 4), textcoords="offset points", fontsize=SMALL, color=QUIET, ha="center")


@styled
def error_over_time(race: str, rows: Sequence[TransferRow]) -> Figure:
    """Tracking error over time: a chart for each world, a thin line for each flight; a cross where a gate was first missed."""
    names, labels = _worlds(rows), _labels(rows)
    height = TOP + GAP / 2 + len(names) * TALL + (len(names) - 1) * GAP + BOTTOM
    figure = Figure(figsize=(LEFT + LONG + RIGHT, height))
    top, end = _top(rows), max((float(flight.times[-1]) for row in rows for flight in row.flights if len(flight.times)), default=1.0)
    for k, name in enumerate(names):
        axes = place_axes(figure, LEFT, height - TOP - GAP / 2 - (k + 1) * TALL - k * GAP, LONG, TALL)
        axes.grid(visible=True)
        axes.set_xlim(0, end)
        axes.set_ylim(0, top)
        for row in sorted((row for row in rows if row.world == name), key=lambda row: labels.index(row.label)):
            _draw_flights(axes, row, top)
        axes.set_title(name, fontsize=NORMAL, loc="left", pad=3)
        axes.set_ylabel("error [m]")
        if k < len(names) - 1:
            axes.tick_params(labelbottom=False)
        else:
            axes.set_xlabel("time [s]")
    crosses = [("×", FAILURE, "first gate missed, or crash")] * any(row.complete.rate != 1 for row in rows)
    detail = "distance from the clocked reference; a line a flight, with the same noise in all worlds"
    headline(figure, LEFT, f"{race}: tracking error over time", detail, [*_key(labels, "━"), *crosses])
    return figure


def _draw_flights(axes: Axes, row: TransferRow, top: float) -> None:
    """All flights of one set of parameters."""
    for flight in row.flights:
        axes.plot(flight.times, flight.errors, color=_colour(row.label), linewidth=0.7, alpha=0.85)
        if not flight.complete and len(flight.times):
            error = float(np.interp(flight.end_time, flight.times, flight.errors))
            axes.plot(flight.end_time, min(error, 0.95 * top), marker="x", color=FAILURE, markersize=5, zorder=4, clip_on=False)


def _top(rows: Sequence[TransferRow]) -> float:
    """[m] as far as the charts reach: to the largest error, but not where a crash would make all flights that are complete flat."""
    largest = {complete: [_largest(row, complete=complete) for row in rows] for complete in (True, False)}
    whole, others = (max(largest[complete]) for complete in (True, False))
    return 1.05 * (max(whole, min(others, REACH * whole)) if whole else others) or 1.0


def _largest(row: TransferRow, *, complete: bool) -> float:
    """[m] largest error of the flights that passed every gate, or of the others; 0 where there are none."""
    return max((float(flight.errors.max(initial=0.0)) for flight in row.flights if flight.complete is complete), default=0.0)


def _worlds(rows: Sequence[TransferRow]) -> list[str]:
    return list(dict.fromkeys(row.world for row in rows))


def _labels(rows: Sequence[TransferRow]) -> list[str]:
    """Names of the sets of parameters: what was there first to the left."""
    names = dict.fromkeys(row.label for row in rows)
    return sorted(names, key=lambda name: name != DEFAULT)


def _colour(label: str) -> str:
    """The colour of a set of parameters; one that has none of its own is tuned otherwise."""
    return COLOURS.get(label, AGAIN)


def _key(labels: Sequence[str], mark: str = "■") -> list[tuple[str, str, str]]:
    """The legend."""
    return [(mark, _colour(label), label) for label in labels]


def _passed(rows: Sequence[TransferRow], name: str) -> str:
    """A world, and below it how many flights passed every gate with each set."""
    mine = sorted((row for row in rows if row.world == name), key=lambda row: row.label != DEFAULT)
    shares = ", ".join(f"{row.complete.successes}/{row.complete.flights}" for row in mine)
    return f"{name}\nall gates: {shares}"
