"""Progress curve: completion of the best candidate over flights, each flight credited at its own number."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from hotlap.core.ledger import Ledger
from hotlap.core.seeds import Stream
from hotlap.tuning.candidate import Candidate
from hotlap.tuning.loop import Batch

Point = tuple[int, float]
Rank = tuple[bool, float, float, float]
"""As `Candidate.rank`."""


@dataclass
class ProgressCurve:
    """The curve of one run, which grows with its batches.

    Within a batch a candidate counts by its flights so far, as unconfirmed; at the end of the batch by what the run says of it. So a
    candidate that flies well once and badly when it is flown again raises the curve, and lowers it with the flight that failed.

    Attributes:
        points: (number of the flight from 1, completion of the best candidate after it), wherever that changed.
    """

    points: list[Point] = field(default_factory=list)
    _best: Candidate | None = None

    def follow(self, batch: Batch) -> None:
        """Add the flights of a batch."""
        for flight, completion in _within(batch.ledger, self._best):
            self._reach(flight, completion)
        self._reach(batch.flights, batch.best.completion)
        self._best = batch.best

    def _reach(self, flight: int, completion: float) -> None:
        """Add a point, in place of an earlier one of the same flight."""
        if self.points and self.points[-1][0] == flight:
            self.points.pop()
        if not self.points or self.points[-1][1] != completion:
            self.points.append((flight, completion))


def _within(ledger: Ledger, best: Candidate | None) -> Iterator[Point]:
    """Each search flight and re-flight of a batch, with the completion of the best candidate after it."""
    flown: dict[bytes, tuple[int, float, float]] = {}  # by parameters: flights, and sums of completion and cost
    rows = (stream in {Stream.SEARCH, Stream.CONFIRMATION} for stream in ledger.streams.tolist())
    for row in sorted((i for i, counts in enumerate(rows) if counts), key=lambda i: ledger.numbers[i]):
        key = ledger.parameters[row].tobytes()
        count, completion, cost = flown.get(key, (0, 0.0, 0.0))
        flown[key] = count + 1, completion + float(ledger.completion[row]), cost + float(ledger.cost[row])
        ranks: list[Rank] = [(False, 0.0, completion / n, -cost / n) for n, completion, cost in flown.values()]
        yield int(ledger.numbers[row]) + 1, max(ranks if best is None else [*ranks, best.rank])[2]
