"""Statistics of benchmarks: quantiles of runs that may not have ended, intervals by resampling, profiles.

A run that did not reach its goal has an infinite cost: it is censored, not left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Statistic = Callable[[Floats], Floats]
"""Shape (R, n) to (R,): a number for each row."""

RESAMPLES = 2000
LEVEL = 0.95


def quantile(values: Floats, share: float) -> float:
    """The value below which a share of all lies, interpolated between finite neighbours; infinite where it reaches into those.

    Args:
        values: shape (n,), n at least 1; may be infinite.
        share: 0 to 1.
    """
    ordered = np.sort(values)
    place = share * (len(ordered) - 1)
    below, above = ordered[math.floor(place)], ordered[math.ceil(place)]
    rest = place - math.floor(place)
    return float(below) if not rest else float(below + rest * (above - below)) if np.isfinite(below) else float(above)


def quartiles(values: Floats) -> tuple[float, float, float]:
    """Lower quartile, median and upper quartile, shape (n,)."""
    return quantile(values, 0.25), quantile(values, 0.5), quantile(values, 0.75)


def means(rows: Floats) -> Floats:
    """The mean of each row."""
    return rows.mean(axis=1)


def medians(rows: Floats) -> Floats:
    """The median of each row; values may be infinite."""
    return np.median(rows, axis=1)


def bootstrap_interval(values: Floats, statistic: Statistic, *, seed: int = 0) -> tuple[float, float]:
    """Percentile interval of a statistic at `LEVEL` (Efron, Tibshirani, "An introduction to the bootstrap", 1993, Sec. 13.3).

    Where all values are the same it has no width, however few they are: for a rate of none or all, take Wilson's interval.

    Args:
        values: shape (n,), n at least 1; may be infinite.
        statistic: `means`, `medians` or another.
        seed: of the resampling; the same seed gives the same interval.
    """
    chosen = np.random.default_rng(seed).integers(len(values), size=(RESAMPLES, len(values)))
    drawn = statistic(values[chosen])
    return quantile(drawn, (1 - LEVEL) / 2), quantile(drawn, (1 + LEVEL) / 2)


def performance_ratios(costs: Floats) -> Floats:
    """r = t / min_s t, the cost of each solver over that of the best one on the same problem (Dolan, More, 2002, Sec. 2).

    Args:
        costs: shape (S, P), positive, infinite where a solver failed.

    Returns:
        Shape (S, P), at least 1; infinite where a solver failed.
    """
    best = costs.min(axis=0)
    return np.where(np.isfinite(costs), costs, np.inf) / np.where(np.isfinite(best), best, 1.0)


def performance_profile(ratios: Floats, factors: Floats) -> Floats:
    """rho_s(tau): share of the problems that a solver solved at no more than tau times the cost of the best (their Eq. 2.1).

    Args:
        ratios: shape (S, P).
        factors: shape (F,), each at least 1.

    Returns:
        Shape (S, F).
    """
    return (ratios[:, :, None] <= factors).mean(axis=1)
