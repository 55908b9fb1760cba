"""Goal: what a flight must achieve for the search to stop and confirm (the user's criterion, Sec. IV-A of the paper)."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.core.records import Scores
from hotlap.tuning.goal_forms import FORMS
from hotlap.tuning.scoring import Metric


class Quantity(StrEnum):
    """The quantity that a goal sets a limit to."""

    COMPLETION = "completion"
    MEAN_ERROR = "mean_error"
    MAX_ERROR = "max_error"
    NONE = "none"


_GOAL = re.compile(r"\s*(?P<quantity>[a-z_]+)\s*(?P<relation>>=|<=|=|<)\s*(?P<threshold>[0-9.eE+-]+)\s*")


@dataclass(frozen=True)
class Goal:
    """A criterion for one flight.

    Attributes:
        quantity: what has the limit.
        threshold: least completion (0 to 1), or an error [m] to stay below on a complete flight; without meaning for NONE.
    """

    quantity: Quantity = Quantity.COMPLETION
    threshold: float = 1.0

    def __str__(self) -> str:
        if self.quantity is Quantity.NONE:
            return self.quantity.value
        return f"{self.quantity.value}{'=' if self.quantity is Quantity.COMPLETION else '<'}{self.threshold:.15g}"

    @property
    def metric(self) -> Metric:
        """The metric whose minimum is this goal."""
        return Metric.MEAN_ERROR if self.quantity in {Quantity.MEAN_ERROR, Quantity.MAX_ERROR} else Metric.TIME

    def met(self, scores: Scores) -> NDArray[np.bool_]:
        """Which flights meet the goal, shape (B,); none for NONE: the budget is spent to its end.

        An error counts on complete flights alone: a drone that crashes at once has hardly left the reference.
        """
        if self.quantity is Quantity.COMPLETION:
            return scores.completion >= self.threshold
        if self.quantity is Quantity.MEAN_ERROR:
            return scores.complete & (scores.mean_error < self.threshold)
        if self.quantity is Quantity.MAX_ERROR:
            return scores.complete & (scores.max_error < self.threshold)
        return np.zeros(len(scores), dtype=np.bool_)

    def succeeded(self, scores: Scores) -> NDArray[np.bool_]:
        """Which flights count as successes in a validation, shape (B,): those that meet the goal; for NONE, the complete ones."""
        return scores.complete if self.quantity is Quantity.NONE else self.met(scores)


def parse_goal(text: str) -> Goal:
    """A goal from its text, as on the command line.

    Args:
        text: one of `FORMS`.

    Raises:
        InputError: when it is anything else.
    """
    if text.strip() == Quantity.NONE:
        return Goal(Quantity.NONE, 0.0)
    match = _GOAL.fullmatch(text)
    if match is None or match["quantity"] not in set(Quantity) - {Quantity.NONE}:
        raise InputError("", "goal", f"'{text}' is no goal; write {FORMS}")
    quantity = Quantity(match["quantity"])
    relations = {"=", ">="} if quantity is Quantity.COMPLETION else {"<", "<="}
    if match["relation"] not in relations:
        raise InputError("", "goal", f"{quantity.value}{match['relation']} makes no sense; write {FORMS}")
    return Goal(quantity, _threshold(quantity, match["threshold"]))


def _threshold(quantity: Quantity, text: str) -> float:
    """The number of a goal, within its range."""
    try:
        threshold = float(text)
    except ValueError:
        raise InputError("", "goal", f"'{text}' is no number; write {FORMS}") from None
    if quantity is Quantity.COMPLETION and not 0 < threshold <= 1:
        raise InputError("", "goal", f"a completion is a fraction above 0 and at most 1, not {threshold:g}")
    if not 0 < threshold < np.inf:
        raise InputError("", "goal", f"an error is a positive number of metres, not {threshold:g}")
    return threshold
