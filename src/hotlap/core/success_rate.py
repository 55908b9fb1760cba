"""Success rate: the share of validation flights that succeed, with its confidence interval."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hotlap.core.shown import Shown

FLIGHTS = 200
RELIABILITY = 0.9  # least success rate of a reliable result; see docs/tuners.md, "How many re-flights make a controller hold"
Z_95 = 1.959963984540054  # the normal quantile of a two-sided 95 % interval


@dataclass(frozen=True, repr=False)
class Validation(Shown):
    """Successes among independent flights.

    Attributes:
        flights: how many were flown.
        successes: how many met the goal.
    """

    flights: int
    successes: int

    @property
    def rate(self) -> float:
        """Share of successes, 0 to 1."""
        return self.successes / self.flights

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the rate."""
        return wilson_interval(self.successes, self.flights)


def wilson_interval(successes: int, flights: int, z: float = Z_95) -> tuple[float, float]:
    """Score interval of a rate (E. B. Wilson, J. Am. Stat. Assoc. 22, 1927); it covers well also at rates of 0 and 1.

    Args:
        successes: of `flights`.
        flights: at least 1.
        z: normal quantile; default for 95 %.
    """
    rate = successes / flights
    centre = rate + z**2 / (2 * flights)
    half_width = z * math.sqrt(rate * (1 - rate) / flights + z**2 / (4 * flights**2))
    scale = 1 + z**2 / flights
    low, high = (centre - half_width) / scale, (centre + half_width) / scale
    return max(low, 0.0) if successes else 0.0, min(high, 1.0) if successes < flights else 1.0
