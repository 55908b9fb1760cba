"""Identification chart: what sensors measured, and what was predicted, on the seconds of a log that were not fitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hotlap.core.counts import count
from hotlap.core.records import Floats
from hotlap.identification.held_out import EVERY, PIECE, Prediction, pieces
from hotlap.identification.identify import Identification
from hotlap.report.style import AGAIN, BEST, FAINT, FIRST, INK, SMALL, headline, place_axes, styled

LEFT, RIGHT, TOP, BOTTOM = 0.7, 1.2, 0.85, 0.5  # inches
WIDTH, HEIGHT, GAP = 8.4, 1.05, 0.22  # inches of a row, and between two
TITLES = {"rates": ("roll rate", "pitch rate", "yaw rate"), "force": ("force x", "force y", "force z")}
TITLES["velocity"] = ("velocity x", "velocity y", "velocity z")
KEY = (("—", FIRST, "measured"), ("—", BEST, "predicted by what was identified"), ("—", AGAIN, "by the base"))


@styled
def identification(found: Identification, log: int = 0) -> Figure:
    """Every channel of one log below each other, the seconds that were not fitted side by side.

    Args:
        found: what was identified.
        log: place of the log.
    """
    shown = [one for one in found.predictions if one.log == log]
    high = len(shown) * HEIGHT + (len(shown) - 1) * GAP
    figure = Figure(figsize=(LEFT + WIDTH + RIGHT, TOP + high + BOTTOM))
    for row, one in enumerate(shown):
        axes = place_axes(figure, LEFT, BOTTOM + (len(shown) - 1 - row) * (HEIGHT + GAP), WIDTH, HEIGHT)
        _draw(axes, one, last=row == len(shown) - 1)
    seconds = f"{found.logs[log]}: every {_ordinal(EVERY)} second, which was not fitted; {count(len(shown), 'channel')}"
    if any(one.channel == "velocity" for one in shown):
        seconds += "; velocities are predicted from where each second begins"
    headline(figure, LEFT, f"Predicted against measured, on the base {found.base.name}", seconds, KEY)
    return figure


def _ordinal(number: int) -> str:
    return {2: "second", 3: "third", 4: "fourth", 5: "fifth"}.get(number, f"{number}th")


def _draw(axes: Axes, one: Prediction, *, last: bool) -> None:
    """One channel: pieces joined, thin lines between them."""
    piece = pieces(one.times, 0.0)
    parts = [np.flatnonzero(piece == number) for number in np.unique(piece)]
    at = 0.0
    places, ticks = [], []
    for rows in parts:
        within = at + one.times[rows] - piece[rows[0]] * PIECE
        for values, colour, width, order in _lines(one):
            axes.plot(within, values[rows], color=colour, linewidth=width, zorder=order)
        axes.axvline(at, color=FAINT, linewidth=0.6, zorder=0)
        places.append(at + PIECE / 2)
        ticks.append(f"{piece[rows[0]] * PIECE:g}")
        at += PIECE
    axes.set_xlim(0, at)
    low = min(float(one.measured.min()), float(one.predicted.min()))
    high = max(float(one.measured.max()), float(one.predicted.max()))
    room = 0.08 * (high - low) + 1e-9
    axes.set_ylim(low - room, high + room)
    axes.set_xticks(places, ticks if last else [""] * len(places))
    if last:
        axes.set_xlabel("second of the log that begins here [s]")
    title = TITLES[one.channel]["xyz".index(one.axis)]
    axes.set_ylabel(f"{title}\n[{one.unit}]", fontsize=SMALL)
    words = f"off by (rms)\n{one.error:.3g} {one.unit}\nbase {one.former_error:.3g}\nof {one.size:.3g}"
    axes.text(1.012, 0.5, words, transform=axes.transAxes, fontsize=SMALL, color=INK, va="center", ha="left")


def _lines(one: Prediction) -> Sequence[tuple[Floats, str, float, float]]:
    return ((one.measured, FIRST, 2.2, 2.0), (one.believed, AGAIN, 0.9, 1.0), (one.predicted, BEST, 0.9, 3.0))
