"""Pictures of a comparison of tuners: completion over flights on each race, and a performance profile over all races."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

from hotlap.analysis.comparison import Run
from hotlap.analysis.comparison_table import profiles
from hotlap.report.comparison_curves import Curves, curves_of
from hotlap.report.comparison_looks import DASHES, LIGHT, looks_of
from hotlap.report.pictures import save
from hotlap.report.style import LINE, NORMAL, SMALL, headline, headline_width, place_axes, styled

WIDTH, HEIGHT, GAP = 2.5, 1.5, 0.5  # inches of a chart, and between charts
LEFT, TOP, BOTTOM, KEY_LINE = 0.62, 0.75, 0.5, 0.18
BOTTOM_OF_AXIS, TOP_OF_AXIS = -7, 109  # per cent, with room for lines side by side
AXIS = 0.12  # inches for the name of an axis
APART = LINE + 0.2  # points between lines that coincide
ACROSS = 4  # charts in a row
BAND_UP_TO = 6  # tuners; bands of more would hide each other
TITLE = "Tuners on equal terms"
FACTORS = np.geomspace(1, 100, 200)


def draw_comparison(folder: Path, runs: Sequence[Run]) -> tuple[Path, ...]:
    """Draw the curves and the performance profile.

    Args:
        folder: for the pictures.
        runs: at least one.

    Returns:
        The files.

    Raises:
        InputError: when one cannot be written.
    """
    return save(folder / "curves.png", curves(runs)), save(folder / "profile.png", profile(runs))


@styled
def curves(runs: Sequence[Run]) -> Figure:
    """Completion of the best candidate so far over flights, median of all seeds; with few tuners, quartiles as a band."""
    races, looks = list(dict.fromkeys(run.race for run in runs)), _looks(runs)
    across = min(ACROSS, len(races))
    down = math.ceil(len(races) / across)
    key_height = KEY_LINE * (math.ceil(len(looks) / across) + 1)
    seeds = len({run.seed for run in runs})
    medians = f"median of {seeds} seeds{' and quartiles' if len(looks) <= BAND_UP_TO else ''}"
    detail = f"best candidate so far over flights, {medians}; lines that coincide lie side by side"
    width = max(LEFT + across * (WIDTH + GAP), LEFT + headline_width(TITLE, detail, ()) + 0.1)
    figure = Figure(figsize=(width, TOP + down * (HEIGHT + GAP) + AXIS + key_height))
    height = float(figure.get_size_inches()[1])
    for k, race in enumerate(races):
        column, row = k % across, k // across
        axes = place_axes(figure, LEFT + column * (WIDTH + GAP), height - TOP - (row + 1) * HEIGHT - row * GAP, WIDTH, HEIGHT)
        _draw_race(axes, curves_of(race, runs), looks)
        if column == 0:
            axes.set_ylabel("completion [%]")
        if k + across >= len(races):
            axes.set_xlabel("flights, re-flights included")
    headline(figure, LEFT, TITLE, detail)
    _draw_key(figure, looks, across)
    return figure


@styled
def profile(runs: Sequence[Run]) -> Figure:
    """Share of all races and seeds solved within a factor of the fastest tuner's search flights (Dolan, More, 2002)."""
    looks = _looks(runs)
    width, height = 5.5, 3.0
    figure = Figure(figsize=(LEFT + width + 2.4, BOTTOM + height + TOP))
    axes = place_axes(figure, LEFT, BOTTOM, width, height)
    axes.grid(visible=True)
    for tuner, shares in profiles(runs, FACTORS).items():
        axes.step(FACTORS, 100 * shares, where="post", **looks[tuner], label=tuner)
    axes.set_xscale("log")
    axes.set_xlim(1, FACTORS[-1])
    axes.set_ylim(-2, 104)
    _plain_ticks(axes, (1, 2, 5, 10, 20, 50, 100))
    axes.set_xlabel("search flights, as a multiple of the fastest tuner's on the same race and seed")
    axes.set_ylabel("solved [%]")
    figure.legend(loc="center left", bbox_to_anchor=((LEFT + width + 0.15) / (LEFT + width + 2.4), 0.5), fontsize=SMALL, frameon=False)
    headline(figure, LEFT, "Performance profile", "share of all races and seeds in which a candidate was confirmed")
    return figure


def _draw_race(axes: Axes, curves: Curves, looks: Mapping[str, Mapping[str, Any]]) -> None:
    """Completion over flights of all tuners on one race."""
    axes.grid(visible=True)
    longest = int(curves.flights[-1])
    percent_a_point = (TOP_OF_AXIS - BOTTOM_OF_AXIS) / (72 * HEIGHT)
    for i, tuner in enumerate(curves.tuners):
        moved = 100 * curves.middle[i] + curves.shifts[i] * APART * percent_a_point
        axes.step(curves.flights, moved, where="post", **looks[tuner])
        if len(looks) <= BAND_UP_TO:
            low, high = 100 * curves.low[i], 100 * curves.high[i]
            axes.fill_between(curves.flights, low, high, step="post", color=looks[tuner]["color"], alpha=0.15, linewidth=0)
    axes.set_xscale("log")
    axes.set_xlim(1, max(longest, 2))
    axes.set_ylim(BOTTOM_OF_AXIS, TOP_OF_AXIS)
    axes.set_yticks([0, 25, 50, 75, 100])
    _plain_ticks(axes, [tick for tick in (1, 3, 10, 30, 100, 300, 1000, 3000) if tick <= longest])
    axes.set_title(curves.race, fontsize=NORMAL, loc="left", pad=4)


def _plain_ticks(axes: Axes, ticks: Sequence[float]) -> None:
    """Ticks of a logarithmic axis as plain numbers."""
    axes.xaxis.set_major_locator(FixedLocator(list(ticks)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def _looks(runs: Sequence[Run]) -> dict[str, dict[str, Any]]:
    """Colour and dashes of each tuner as matplotlib takes them."""
    looks = looks_of(list(dict.fromkeys(run.tuner for run in runs)))
    return {
        name: {"color": LIGHT[look.colour], "linestyle": (0, DASHES[look.dashes]) if DASHES[look.dashes] else "-", "linewidth": LINE}
        for name, look in looks.items()
    }


def _draw_key(figure: Figure, looks: Mapping[str, Mapping[str, Any]], across: int) -> None:
    """The legend below the charts."""
    width, height = (float(value) for value in figure.get_size_inches())
    for k, (tuner, look) in enumerate(looks.items()):
        left, level = LEFT + (k % across) * (WIDTH + GAP), KEY_LINE * (math.ceil(len(looks) / across) - k // across)
        axes = place_axes(figure, left, level - 0.06, 0.3, 0.12)
        axes.plot([0, 1], [0, 0], **look)
        axes.set_axis_off()
        figure.text((left + 0.36) / width, level / height, tuner, fontsize=SMALL, va="center")
