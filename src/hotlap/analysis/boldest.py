"""Boldest: of plans from bold to calm, the boldest that its tuned controller holds.

The shares of the thrust are tried from the top; after two that fail every second one is left out, and comes back when the next one holds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from hotlap.race.race import Race
from hotlap.study.tried_plan import TriedPlan

SHARES = (0.92, 0.85, 0.75, 0.65, 0.55, 0.45, 0.35, 0.25)  # of the thrust; beyond the first nothing is left to correct with
BARELY = 1.15  # thrust-to-weight below which a plan makes no sense
STEADY = 2  # failures in a row after which every second share is left out

Attempt = Callable[[float], TriedPlan | None]


def shares_of(race: Race, below: float = 1.0) -> tuple[float, ...]:
    """The shares of the thrust that are worth trying, from bold to calm.

    Args:
        race: whose vehicle is to be carried.
        below: share that all of them are below.
    """
    lift = race.control_model.thrust_to_weight
    return tuple(share for share in SHARES if share < below and share * lift >= BARELY)


def find_boldest(shares: Sequence[float], attempt: Attempt) -> list[TriedPlan]:
    """Try plans until the boldest that holds is found, or none is left.

    Args:
        shares: of the thrust, from bold to calm.
        attempt: tries a share; None where nothing is left to try it with.

    Returns:
        What was tried, in the order tried.
    """
    found: list[TriedPlan] = []
    i, skipped = 0, -1
    while i < len(shares):
        tried = attempt(shares[i])
        if tried is None:
            return found
        found.append(tried)
        if tried.holds:
            break
        step = 2 if len(found) >= STEADY and i + 2 < len(shares) else 1
        skipped = i + 1 if step == 2 else -1
        i += step
    if found and found[-1].holds and skipped >= 0:
        between = attempt(shares[skipped])
        found += [] if between is None else [between]
    return found
