"""History: the flights of a search, and the change of its parameters, as plain arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.ledger import Ledger
from hotlap.core.parameters import Parameters, ParameterSpace
from hotlap.core.seeds import Stream
from hotlap.reference.segmentation import Segments
from hotlap.tuning.goal import Goal, Quantity

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

CHAINS = ("metropolis_hastings", "simulated_annealing", "tempered")
"""Tuners that are Markov chains: what they accept is where they go on from, whatever the goal says of the flight."""


@dataclass(frozen=True)
class History:
    """Search flights and re-flights in the order flown.

    Attributes:
        numbers: shape (F,) from 1.
        cost: shape (F,), lower is better; not finite where a flight has none.
        completion: shape (F,), 0 to 1.
        searching: shape (F,) false for re-flights.
        failed: shape (F,) whether a flight missed the goal; without a goal, whether it was incomplete.
        tuned: shape (F,) whether a flight was with the parameters that are the result.
        cost_name: what the cost measures, with its unit.
        goal: whether there is one.
    """

    numbers: NDArray[np.int64]
    cost: Floats
    completion: Floats
    searching: Booleans
    failed: Booleans
    tuned: Booleans
    cost_name: str
    goal: bool

    def __len__(self) -> int:
        """F, the number of flights."""
        return len(self.numbers)

    @property
    def best_completion(self) -> Floats:
        """Largest completion of the search flights so far, shape (F,); NaN before the first."""
        return np.fmax.accumulate(np.where(self.searching, self.completion, np.nan))

    @property
    def best_cost(self) -> Floats:
        """Least cost of the search flights so far, shape (F,); NaN before the first."""
        return np.fmin.accumulate(np.where(self.searching & np.isfinite(self.cost), self.cost, np.nan))


@dataclass(frozen=True)
class Samples:
    """Parameters and results of the R search flights, without re-flights.

    Attributes:
        parameters: shape (R, S, K).
        accepted: shape (R,) whether a chain (`CHAINS`) accepted the candidate; other tuners have no such verdict.
        completion: shape (R,), 0 to 1.
        succeeded: shape (R,) whether the goal was met.
        goal: whether there is one; else `succeeded` says whether every gate was passed.
    """

    parameters: Parameters
    accepted: Booleans
    completion: Floats
    succeeded: Booleans
    goal: bool

    def __len__(self) -> int:
        """R, the number of flights."""
        return len(self.accepted)


@dataclass(frozen=True)
class Change:
    """Parameters before and after tuning.

    Attributes:
        names: K names.
        units: K units; "" for weights.
        low, high: bounds, shape (K,).
        before, after: shape (S, K).
        segments: S segments.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    low: Floats
    high: Floats
    before: Parameters
    after: Parameters
    segments: Segments


def recount(ledger: Ledger, goal: Goal, cost_name: str, best: Parameters | None = None) -> History:
    """The search flights and re-flights of a ledger, without selection and validation.

    Args:
        ledger: all flights of the study.
        goal: that decides which flights failed.
        cost_name: what the cost measures, with its unit.
        best: shape (S, K), the parameters that are the result; None: there are none yet.
    """
    rows = np.flatnonzero(np.isin(ledger.streams, (Stream.SEARCH, Stream.CONFIRMATION)))
    return History(
        numbers=ledger.numbers[rows] + 1,
        cost=ledger.cost[rows],
        completion=ledger.completion[rows],
        searching=ledger.streams[rows] == int(Stream.SEARCH),
        failed=~succeeded(ledger, goal)[rows],
        tuned=with_parameters(ledger, best)[rows],
        cost_name=cost_name,
        goal=goal.quantity is not Quantity.NONE,
    )


def collect(ledger: Ledger, goal: Goal, most: int | None = None) -> Samples:
    """The search flights of a ledger; at most `most` of them, spread evenly."""
    search = ledger.of(Stream.SEARCH)
    kept = min(most or len(search), len(search))
    rows = np.unique(np.linspace(0, len(search) - 1, kept).round().astype(int)) if kept else np.zeros(0, dtype=int)
    met = succeeded(search, goal)
    return Samples(search.parameters[rows], search.accepted[rows], search.completion[rows], met[rows], goal.quantity is not Quantity.NONE)


def compare(space: ParameterSpace, segments: Segments, before: Parameters, after: Parameters, horizon_unit: float) -> Change:
    """The change of the parameters from before to after tuning.

    Args:
        space: of the parameters.
        segments: S segments.
        before: shape (S, K).
        after: shape (S, K).
        horizon_unit: [s] time of a horizon parameter of 1.
    """
    units = tuple(f"{horizon_unit:g} s" if name == "horizon" else "" for name in space.names)
    return Change(space.names, units, space.low, space.high, before, after, segments)


def succeeded(ledger: Ledger, goal: Goal) -> Booleans:
    """Whether each flight met the goal, shape (F,); without a goal, whether it passed all gates."""
    if goal.quantity is Quantity.COMPLETION:
        return ledger.completion >= goal.threshold
    errors = {Quantity.MEAN_ERROR: ledger.mean_error, Quantity.MAX_ERROR: ledger.max_error}
    complete = ledger.completion >= 1
    return complete & (errors[goal.quantity] < goal.threshold) if goal.quantity in errors else complete


def with_parameters(ledger: Ledger, parameters: Parameters | None) -> Booleans:
    """Whether each flight was with these parameters, shape (F,); none of them where there are none."""
    if parameters is None:
        return np.zeros(len(ledger), dtype=np.bool_)
    return np.all(ledger.parameters == parameters, axis=(1, 2))


def verdicts(*, goal: bool) -> tuple[str, str]:
    """What is said of flights that met the goal and of those that did not; without a goal, of those that passed every gate."""
    return ("passed the goal", "failed the goal") if goal else ("passed every gate", "missed a gate")
