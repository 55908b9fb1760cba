"""Selection: which of many candidates is handed over, where none was confirmed: the one with the best lower bound on its success rate.

Among many candidates, that with the luckiest flight is rarely the most reliable, and the more flights, the luckier it is. So the candidates
that look best are flown again, with noise of their own, by sequential halving (Z. Karnin, T. Koren, O. Somekh, ICML 2013): every round has
the same number of flights, shared out equally among those that are left, and half of them go on. Candidates that failed a validation join
for the last rounds, with its flights.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hotlap.core.parameters import Parameters
from hotlap.core.plain import typed, value_of
from hotlap.core.records import Scores
from hotlap.core.success_rate import wilson_interval
from hotlap.tuning.candidate import Candidate
from hotlap.tuning.goal import Goal, Quantity

FINALISTS = 32
KNOWN = 4  # candidates with a validation that join when so few are left
FAR = 1e9  # what a cost that is not finite, or larger, counts as

Merit = tuple[float, ...]


def merit(flown: Scores, goal: Goal, validation_rate: float = 0.0) -> Merit:
    """How good a candidate looks by all its flights, the larger the better: lower bounds on its success rate, completion, cost.

    Args:
        flown: its flights.
        goal: that makes one a success.
        validation_rate: of a validation that it failed.
    """
    successes, completion = int(goal.succeeded(flown).sum()), float(flown.completion.mean())
    costs = flown.dense if goal.quantity is Quantity.COMPLETION else flown.cost
    cost = float(np.minimum(np.nan_to_num(costs, nan=FAR, posinf=FAR), FAR).mean())
    return validation_rate, wilson_interval(successes, len(flown))[0], completion, -cost


def mixed(ours: Sequence[Parameters], theirs: Sequence[Parameters]) -> list[Parameters]:
    """One of each in turn, then what is left, each once."""
    turns = [one for pair in zip(ours, theirs, strict=False) for one in pair]
    return list({one.tobytes(): one for one in [*turns, *ours[len(theirs) :], *theirs[len(ours) :]]}.values())


@dataclass
class Contenders:
    """The candidates of a search that looked best, as a list that only grows.

    Attributes:
        entries: parameters, shape (S, K), and merit of each that was among the best `FINALISTS` when it was flown.
    """

    entries: list[tuple[Parameters, Merit]] = field(default_factory=list)

    def add(self, parameters: Parameters, merit: Merit) -> None:
        """Keep a candidate if it is among the best so far."""
        best = self._best()
        if len(best) < FINALISTS or merit > self.entries[best[-1]][1]:
            self.entries.append((parameters.copy(), merit))

    def best(self) -> list[Parameters]:
        """The best of them, the best first, each once."""
        found = {self.entries[i][0].tobytes(): self.entries[i][0] for i in self._best()}
        return list(found.values())

    def _best(self) -> list[int]:
        """Indices of the best, the best first; of equals, the earlier first."""
        return sorted(range(len(self.entries)), key=lambda i: self.entries[i][1], reverse=True)[:FINALISTS]

    def dump(self) -> list[Any]:
        """As plain JSON."""
        return [[parameters.tolist(), list(merit)] for parameters, merit in self.entries]

    @staticmethod
    def load(plain: Sequence[Any]) -> Contenders:
        """The inverse of `dump`."""
        return Contenders([(np.array(parameters), tuple(merit)) for parameters, merit in plain])


@dataclass(frozen=True)
class Finalist:
    """A candidate, with sums over the flights that it flew in the selection.

    Attributes:
        parameters: shape (S, K).
        flights, successes: how many.
        completion, cost: sums.
        lap_time: [s] sum over its complete flights.
        laps: how many were complete.
    """

    parameters: Parameters
    flights: int = 0
    successes: int = 0
    completion: float = 0.0
    cost: float = 0.0
    lap_time: float = 0.0
    laps: int = 0

    @property
    def rank(self) -> tuple[float, float, float]:
        """Larger is better: the lower bound on the success rate, the completion, the cost."""
        lower = wilson_interval(self.successes, self.flights)[0] if self.flights else 0.0
        return lower, self.completion / max(self.flights, 1), -self.cost / max(self.flights, 1)

    def flown(self, scores: Scores, goal: Goal) -> Finalist:
        """After further flights."""
        laps = scores.lap_time[np.isfinite(scores.lap_time)]
        return Finalist(
            self.parameters,
            self.flights + len(scores),
            self.successes + int(goal.succeeded(scores).sum()),
            self.completion + float(scores.completion.sum()),
            self.cost + float(np.minimum(np.nan_to_num(scores.cost, nan=FAR, posinf=FAR), FAR).sum()),
            self.lap_time + float(laps.sum()),
            self.laps + len(laps),
        )

    def dump(self) -> dict[str, Any]:
        """As plain JSON."""
        return {**vars(self), "parameters": self.parameters.tolist()}

    @staticmethod
    def load(plain: Mapping[str, Any]) -> Finalist:
        """The inverse of `dump`."""
        return Finalist(**{**typed(Finalist, plain), "parameters": np.array(plain["parameters"])})

    @property
    def candidate(self) -> Candidate:
        """With the means over its flights in the selection."""
        count, laps = self.flights, self.laps
        lap_time = self.lap_time / laps if laps else math.nan
        return Candidate(self.parameters, self.cost / count, self.completion / count, lap_time, count, confirmed=False)

    @property
    def merit(self) -> Merit:
        """As a contender of a search that goes on."""
        lower, completion, cost = self.rank
        return 0.0, lower, completion, cost


@dataclass(frozen=True)
class Selection:
    """Sequential halving, between two rounds.

    Attributes:
        finalists: that are left.
        each_round: flights that a round may take.
        known: candidates that were flown often before, who join when no more than `KNOWN` finalists are left.
    """

    finalists: tuple[Finalist, ...]
    each_round: int
    known: tuple[Finalist, ...] = ()

    @staticmethod
    def begin(candidates: Sequence[Parameters], flights: int, known: Sequence[Finalist] = ()) -> Selection:
        """Before the first round.

        Args:
            candidates: each of shape (S, K), the most promising first; those that flights are too few for are left out.
            flights: that all rounds may take together.
            known: candidates that were flown often before; the best `KNOWN` of them count.
        """
        best = sorted(known, key=lambda one: one.rank, reverse=True)[:KNOWN]
        joined = {one.parameters.tobytes() for one in best}
        unknown = [one for one in candidates if one.tobytes() not in joined]
        count = min(len(unknown), flights)
        rounds = max(1, math.ceil(math.log2(max(count, 1)))) + (1 if best else 0)
        while count > 1 and flights // rounds < count:
            count = flights // rounds
        finalists = tuple(Finalist(parameters) for parameters in unknown[:count])
        return _joined(Selection(finalists, max(1, flights // rounds), tuple(best)))

    @property
    def flights_each(self) -> int:
        """Flights of each finalist in the next round."""
        return max(1, self.each_round // len(self.finalists))

    def after(self, scores: Scores, goal: Goal) -> Selection:
        """After a round: the better half.

        Args:
            scores: `flights_each` of the first finalist, then of the second, ...
            goal: that makes a flight a success.
        """
        each = self.flights_each
        flown = [one.flown(scores.rows(slice(i * each, (i + 1) * each)), goal) for i, one in enumerate(self.finalists)]
        flown.sort(key=lambda one: one.rank, reverse=True)
        return _joined(Selection(tuple(flown[: (len(flown) + 1) // 2]), self.each_round, self.known))

    @property
    def winner(self) -> Finalist | None:
        """The one that is left."""
        return self.finalists[0] if len(self.finalists) == 1 and self.finalists[0].flights else None

    def dump(self) -> dict[str, Any]:
        """As plain JSON."""
        lists = {name: [one.dump() for one in getattr(self, name)] for name in ("finalists", "known")}
        return {**lists, "each_round": self.each_round}

    @staticmethod
    def load(plain: Mapping[str, Any]) -> Selection:
        """The inverse of `dump`."""
        finalists, known = (tuple(Finalist.load(one) for one in plain[name]) for name in ("finalists", "known"))
        return Selection(finalists, value_of("int", "each_round", plain["each_round"]), known)


def _joined(selection: Selection) -> Selection:
    """With those that are known, if it is time."""
    if not selection.known or len(selection.finalists) > KNOWN:
        return selection
    return Selection((*selection.finalists, *selection.known), selection.each_round)
