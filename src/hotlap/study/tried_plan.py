"""TriedPlan: a plan of a race that was tuned to see whether its controller holds it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from hotlap.core.shown import Shown


@dataclass(frozen=True, repr=False)
class TriedPlan(Shown):
    """What became of one plan.

    Attributes:
        share: of the thrust that it may use [-].
        lap_time: [s] as planned; None where there is no plan.
        flights: of its search, re-flights included.
        rate: share of successes of its best parameters in their validation; None where they were not validated.
        holds: whether these hold: confirmed, and enough of these flights succeeded, under every condition that was asked for.
        end: where it does not hold, how most of the other flights ended, or why there is no plan.
    """

    share: float
    lap_time: float | None
    flights: int
    rate: float | None
    holds: bool
    end: str = ""

    @property
    def rank(self) -> tuple[bool, float, float]:
        """Larger is better: the boldest of those that hold, else the one with the most successes."""
        return self.holds, self.share if self.holds else (self.rate or 0.0), -self.share

    def dump(self) -> dict[str, Any]:
        """As plain JSON."""
        return asdict(self)

    @staticmethod
    def load(plain: Mapping[str, Any]) -> TriedPlan:
        """The inverse of `dump`."""
        return TriedPlan(**plain)


def chosen_of(plans: Sequence[TriedPlan]) -> TriedPlan | None:
    """The plan that is flown: of those that are there, the boldest that holds, or the best; None where there is none."""
    return max((plan for plan in plans if plan.lap_time is not None), key=lambda plan: plan.rank, default=None)


def describe_choice(plans: Sequence[TriedPlan]) -> str:
    """In a line, which plan was chosen, and why none that is bolder; "" where none was to be chosen."""
    chosen = chosen_of(plans)
    if chosen is None or chosen.lap_time is None:
        return ""
    planned = f"planned with {_percent(chosen.share)} of the thrust: {chosen.lap_time:.2f} s"
    bolder = min((plan for plan in plans if plan.share > chosen.share), key=lambda plan: plan.share, default=None)
    if not chosen.holds:
        tried = ", ".join(f"{100 * plan.share:.0f}" for plan in plans)
        rate = "" if chosen.rate is None else f", where {_percent(chosen.rate)} of the flights succeed"
        return f"{planned}{rate}; of {tried} % none holds ({chosen.end})"
    return f"{planned}; at {_percent(bolder.share)} {bolder.end}" if bolder else f"{planned}, the boldest that is tried"


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"
