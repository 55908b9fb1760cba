"""Ledger: flights as a study keeps them, one row a flight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters
from hotlap.core.records import Floats, Scores
from hotlap.core.seeds import Stream
from hotlap.core.shown import Framed, Shown, by_column


@dataclass(frozen=True, repr=False)
class Ledger(Shown, Framed):
    """F flights, with the purpose of each.

    Attributes:
        numbers: shape (F,) from 0 in the order flown; search and confirmation are numbered together, validation by itself.
        streams: shape (F,) of `Stream`.
        parameters: shape (F, S, K).
        seeds: shape (F,).
        cost: shape (F,) of this flight alone.
        completion: shape (F,), 0 to 1.
        failed_segment: shape (F,), -1 where all gates were passed.
        mean_error, max_error: shape (F,) [m].
        lap_time: shape (F,) [s], NaN where there is none.
        accepted: shape (F,) whether the tuner went on from this flight's parameters; false for other than search flights.
    """

    numbers: NDArray[np.int64]
    streams: NDArray[np.int64]
    parameters: Parameters
    seeds: NDArray[np.int64]
    cost: Floats
    completion: Floats
    failed_segment: NDArray[np.int64]
    mean_error: Floats
    max_error: Floats
    lap_time: Floats
    accepted: NDArray[np.bool_]

    def __len__(self) -> int:
        """F, the number of flights."""
        return len(self.numbers)

    def records(self) -> list[dict[str, Any]]:
        """A row for each flight; its parameters are an array, shape (S, K)."""
        return by_column(
            {
                "number": self.numbers,
                "stream": [Stream(stream).name.lower() for stream in self.streams.tolist()],
                "seed": self.seeds,
                "completion": self.completion,
                "cost": self.cost,
                "lap_time": self.lap_time,
                "mean_error": self.mean_error,
                "max_error": self.max_error,
                "accepted": self.accepted,
                "parameters": list(self.parameters),
            }
        )

    def of(self, stream: Stream) -> Ledger:
        """The flights that were flown for one purpose."""
        return self.rows(self.streams == stream)

    def rows(self, chosen: slice | NDArray[np.bool_]) -> Ledger:
        """Some of the flights."""
        return Ledger(**{field.name: getattr(self, field.name)[chosen] for field in fields(self)})

    def accept(self, accepted: NDArray[np.bool_]) -> Ledger:
        """The same flights, with the tuner's verdicts, shape (F,)."""
        return replace(self, accepted=accepted)

    @staticmethod
    def join(parts: Sequence[Ledger]) -> Ledger:
        """One ledger behind the other; at least one."""
        return Ledger(**{field.name: np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Ledger)})


def enter(first: int, stream: Stream, parameters: Parameters, seeds: NDArray[np.int64], scores: Scores) -> Ledger:
    """The rows of flights that were flown together.

    Args:
        first: number of the first one.
        stream: what they were flown for.
        parameters: shape (F, S, K).
        seeds: shape (F,).
        scores: of each flight.
    """
    count = len(seeds)
    return Ledger(
        numbers=np.arange(first, first + count),
        streams=np.full(count, int(stream)),
        parameters=parameters,
        seeds=seeds,
        cost=scores.cost,
        completion=scores.completion,
        failed_segment=scores.failed_segment,
        mean_error=scores.mean_error,
        max_error=scores.max_error,
        lap_time=scores.lap_time,
        accepted=np.zeros(count, dtype=np.bool_),
    )
