"""Held out: every fourth second of a log is not fitted; there the fitted vehicle and the base predict what was measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.records import Floats
from hotlap.core.shown import Shown
from hotlap.identification.evidence import stretches
from hotlap.identification.model import SETTLED, Model, Numbers
from hotlap.identification.unknowns import AXES
from hotlap.logs.flight_log import Signal

Mask = NDArray[np.bool_]
PIECE, EVERY = 1.0, 4  # s of a piece; one of so many is held out
UNITS = {"rates": "rad/s", "force": "m/s^2", "velocity": "m/s"}


@dataclass(frozen=True, repr=False)
class Prediction(Shown):
    """One channel of a log where it was not fitted.

    Attributes:
        log: place of it.
        channel: rates, force or velocity.
        axis: x, y or z.
        times: shape (N,) [s] since the log began.
        measured, predicted, believed: shape (N,): by sensors, by the fit without these pieces, and by the base. A velocity is predicted
            from where it is at the beginning of each piece.
    """

    log: int
    channel: str
    axis: str
    times: Floats
    measured: Floats
    predicted: Floats
    believed: Floats

    @property
    def unit(self) -> str:
        """Of the values."""
        return UNITS[self.channel]

    @property
    def error(self) -> float:
        """Root mean square of what the fit leaves."""
        return float(np.sqrt(np.mean((self.measured - self.predicted) ** 2)))

    @property
    def former_error(self) -> float:
        """The same of the base."""
        return float(np.sqrt(np.mean((self.measured - self.believed) ** 2)))

    @property
    def size(self) -> float:
        """Root mean square of the measured, about its mean."""
        return float(self.measured.std())

    def dump(self) -> dict[str, Any]:
        """As in `--json`, without the curves."""
        return {
            "log": self.log,
            "channel": self.channel,
            "axis": self.axis,
            "unit": self.unit,
            "error": self.error,
            "former_error": self.former_error,
            "size": self.size,
        }


def pieces(times: Floats, begin: float) -> NDArray[np.int64]:
    """The piece in which each time lies."""
    return np.asarray((times - begin) / PIECE, dtype=np.int64)


def held_out(times: Floats, begin: float) -> Mask:
    """Which times lie in pieces that are not fitted."""
    return np.asarray(pieces(times, begin) % EVERY == EVERY // 2)


def signals_of(model: Model) -> dict[str, Signal]:
    """What is predicted of a log."""
    found = {"rates": model.evidence.rates, "force": model.evidence.force, "velocity": model.evidence.velocity}
    return {name: signal for name, signal in found.items() if signal is not None}


def predictions(models: Sequence[Model], numbers: Numbers, believed: Numbers) -> tuple[Prediction, ...]:
    """Every channel of every log where it was not fitted.

    Args:
        models: of the logs.
        numbers: of the fit.
        believed: of the base.
    """
    found = []
    for k, model in enumerate(models):
        begin = float(model.evidence.grid[0])
        by_fit, by_base = model.predicted(numbers), model.predicted(believed)
        for name, signal in signals_of(model).items():
            out = held_out(signal.times, begin) & model.evidence.counts[name]
            if not out.any():
                continue
            piece, measured = pieces(signal.times, begin)[out], signal.values[out]
            rows = [one[name][out] for one in (by_fit, by_base)]
            if name == "velocity":  # and where it is after a gap
                piece = piece + (piece[-1] + 1 if len(piece) else 1) * stretches(model.evidence.counts[name])[out]
                rows = [_from_start(one, measured, piece) for one in rows]
            for a, axis in enumerate(AXES):
                found.append(Prediction(k, name, axis, signal.times[out] - begin, measured[:, a], rows[0][:, a], rows[1][:, a]))
    return tuple(found)


def _from_start(predicted: Floats, measured: Floats, piece: NDArray[np.int64]) -> Floats:
    """Predictions that begin in each piece where the measured begin."""
    moved = predicted.copy()
    for one in np.unique(piece):
        rows = piece == one
        moved[rows] += (measured[rows][:SETTLED] - predicted[rows][:SETTLED]).mean(axis=0)
    return moved
