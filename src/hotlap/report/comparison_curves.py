"""Curves of a comparison: completion of the best candidate over flights on one race, and how far lines that coincide are set apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.analysis.comparison import Run
from hotlap.analysis.comparison_table import completion_band

Floats = NDArray[np.float64]

SAME = 0.01  # of completion: lines nearer than that would hide each other
MOST = 2.5  # line widths that a line is moved by at most


@dataclass(frozen=True)
class Curves:
    """What tuners did on a race.

    Attributes:
        race: its name.
        tuners: N names, of those that flew there.
        flights: shape (F,) from 1, re-flights included.
        low, middle, high: shape (N, F) quartiles and median over runs of the best candidate's completion; NaN beyond a tuner's budget.
    """

    race: str
    tuners: tuple[str, ...]
    flights: NDArray[np.int64]
    low: Floats
    middle: Floats
    high: Floats

    @property
    def shifts(self) -> Floats:
        """Line widths by which each line is moved up, so that those which coincide lie side by side; shape (N, F)."""
        return np.column_stack([_apart(column) for column in self.middle.T])


def curves_of(race: str, runs: Sequence[Run]) -> Curves:
    """The curves of all tuners on a race.

    Args:
        race: its name.
        runs: of any races, at least one of this.
    """
    mine: dict[str, list[Run]] = {}
    for run in runs:
        if run.race == race:
            mine.setdefault(run.tuner, []).append(run)
    budgets = {tuner: max(run.budget for run in own) for tuner, own in mine.items()}
    flights = _places(max(budgets.values()))
    bands = [
        np.where(flights <= budgets[tuner], np.array(completion_band(own, flights)), np.nan)  # (3, F)
        for tuner, own in mine.items()
    ]
    low, middle, high = np.stack(bands, axis=1)
    return Curves(race, tuple(mine), flights, low, middle, high)


def _places(longest: int) -> NDArray[np.int64]:
    """Numbers of flights at which a curve is drawn: each of the first hundred, then evenly on the logarithmic axis."""
    return np.unique(np.concatenate([np.arange(1, min(longest, 100) + 1), np.geomspace(1, longest, 100).round()])).astype(np.int64)


def _apart(values: Floats) -> Floats:
    """How far lines at these values, shape (N,), are moved up: those that coincide, by one width from the next, the first on top."""
    shifts = np.zeros(len(values))
    groups: dict[int, list[int]] = {}
    for i, value in enumerate(values.tolist()):
        if np.isfinite(value):
            groups.setdefault(round(value / SAME), []).append(i)
    for group in groups.values():
        half = (len(group) - 1) / 2
        shifts[group] = (half - np.arange(len(group))) * min(1.0, MOST / max(half, 1.0))
    return shifts
