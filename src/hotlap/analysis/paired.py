"""Paired: two tuners on the same races with the same seeds: by how much they differ, and whether that may be chance.

Noise and first guess of a race and a seed are the same for all tuners, so runs are compared pair by pair. Intervals resample the seeds
within each race: they speak of these races, not of others.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.analysis.comparison import Run
from hotlap.analysis.comparison_table import Interval, overall
from hotlap.analysis.statistics import LEVEL, RESAMPLES, Floats, Statistic, means, medians, quantile

DIGITS = 12  # of a difference: what rounding leaves of equal ones must not rank them


@dataclass(frozen=True)
class Difference:
    """What the one has more than the other.

    Attributes:
        pairs: of runs that were compared.
        value: mean or median over pairs; NaN without any.
        interval: 95 %, by resampling seeds within races; None where all pairs differ by the same, and so nothing can be said.
        p: two-sided, corrected for the number of comparisons (Holm, 1979); 1 without a difference.
    """

    pairs: int
    value: float
    interval: Interval | None
    p: float


@dataclass(frozen=True)
class Paired:
    """Two tuners, pair by pair.

    Attributes:
        tuner: the one.
        against: the other.
        pairs: races and seeds that both have flown.
        confirmed: share of runs that confirmed a candidate, one minus other; exact sign test (McNemar).
        validated: share of the validation that succeeded, mean of one minus other; Wilcoxon's signed rank test.
        fewer: pairs in which the one needed fewer search flights; who never confirmed a candidate needed infinitely many.
        more: pairs in which it needed more.
        flights_p: exact sign test of these two, corrected likewise.
        lap_time: by what share the lap of the one is longer, median over pairs that both solved; Wilcoxon's signed rank test.
    """

    tuner: str
    against: str
    pairs: int
    confirmed: Difference
    validated: Difference
    fewer: int
    more: int
    flights_p: float
    lap_time: Difference

    def dump(self) -> dict[str, Any]:
        """As plain values."""
        plain = asdict(self)
        for name in ("confirmed", "validated", "lap_time"):
            low, high = plain[name].pop("interval") or (None, None)
            plain[name] |= {"low": low, "high": high}
        return plain


def paired(runs: Sequence[Run]) -> list[Paired]:
    """Each tuner against each that follows it in `overall`, so that the better one stands first; empty for one tuner alone."""
    by_tuner: dict[str, dict[tuple[str, int], Run]] = {}
    for run in runs:
        by_tuner.setdefault(run.tuner, {})[run.race, run.seed] = run
    names = [row.tuner for row in overall(runs)]
    return _corrected([_pair(by_tuner[one], by_tuner[other], one, other) for one, other in combinations(names, 2)])


def _pair(one: dict[tuple[str, int], Run], other: dict[tuple[str, int], Run], tuner: str, against: str) -> Paired:
    """Two tuners, p not yet corrected."""
    both = [(one[problem], other[problem]) for problem in one if problem in other]
    solved = [(a, b) for a, b in both if a.confirmed and b.confirmed and math.isfinite(a.lap_time) and math.isfinite(b.lap_time)]
    confirmed = np.array([float(a.confirmed) - float(b.confirmed) for a, b in both])
    validated = np.array([a.validated - b.validated for a, b in both]).round(DIGITS)
    laps = np.array([a.lap_time / b.lap_time - 1 for a, b in solved]).round(DIGITS)
    fewer = sum(_flights(a) < _flights(b) for a, b in both)
    more = sum(_flights(a) > _flights(b) for a, b in both)
    races, raced = [a.race for a, _ in both], [a.race for a, _ in solved]
    gained, lost = int((confirmed > 0).sum()), int((confirmed < 0).sum())
    return Paired(
        tuner=tuner,
        against=against,
        pairs=len(both),
        confirmed=_difference(confirmed, races, means, sign_test(gained, lost)),
        validated=_difference(validated, races, means, _signed_rank(validated)),
        fewer=fewer,
        more=more,
        flights_p=sign_test(fewer, more),
        lap_time=_difference(laps, raced, medians, _signed_rank(laps)),
    )


def _flights(run: Run) -> float:
    return run.search_flights if run.confirmed else math.inf


def _difference(values: Floats, races: Sequence[str], statistic: Statistic, p: float) -> Difference:
    """The statistic of pairwise differences, shape (n,), with its interval."""
    if not len(values):
        return Difference(0, math.nan, None, 1.0)
    value = float(statistic(values[None])[0])
    return Difference(len(values), value, stratified_interval(values, races, statistic) if np.ptp(values) else None, p)


def stratified_interval(values: Floats, strata: Sequence[str], statistic: Statistic, *, seed: int = 0) -> Interval:
    """Percentile interval of a statistic at `LEVEL`, by resampling within strata, each of which keeps its size.

    Args:
        values: shape (n,), n at least 1.
        strata: which one each value belongs to.
        statistic: of a row of values.
        seed: of the resampling.
    """
    rng, names = np.random.default_rng(seed), np.array(strata)
    members: list[NDArray[np.intp]] = [np.flatnonzero(names == name) for name in dict.fromkeys(strata)]
    chosen = np.hstack([rows[rng.integers(len(rows), size=(RESAMPLES, len(rows)))] for rows in members])
    drawn = statistic(values[chosen])
    return quantile(drawn, (1 - LEVEL) / 2), quantile(drawn, (1 + LEVEL) / 2)


def sign_test(more: int, less: int) -> float:
    """Two-sided p that of so many pairs which differ, so many differ in one direction by chance; 1 where none differs."""
    if not more + less:
        return 1.0
    from scipy.stats import binomtest  # noqa: PLC0415  half a second

    return float(binomtest(more, more + less).pvalue)


def _signed_rank(values: Floats) -> float:
    """Two-sided p of Wilcoxon's signed rank test; pairs without a difference are left out (Wilcoxon, 1945)."""
    different = values[values != 0]
    if not len(different):
        return 1.0
    from scipy.stats import wilcoxon  # noqa: PLC0415  half a second

    _, p = wilcoxon(different)
    return float(p)  # pyright: ignore[reportArgumentType]  it is a number


def _corrected(rows: list[Paired]) -> list[Paired]:
    """The same with p corrected, each measure for itself."""
    confirmed = holm([row.confirmed.p for row in rows])
    validated = holm([row.validated.p for row in rows])
    flights = holm([row.flights_p for row in rows])
    laps = holm([row.lap_time.p for row in rows])
    return [
        replace(
            row,
            confirmed=replace(row.confirmed, p=confirmed[i]),
            validated=replace(row.validated, p=validated[i]),
            flights_p=flights[i],
            lap_time=replace(row.lap_time, p=laps[i]),
        )
        for i, row in enumerate(rows)
    ]


def holm(values: Sequence[float]) -> list[float]:
    """p values corrected for their number: step down, each at least those before it (Holm, 1979)."""
    corrected, reached = [0.0] * len(values), 0.0
    for rank, i in enumerate(sorted(range(len(values)), key=values.__getitem__)):
        reached = max(reached, min(1.0, (len(values) - rank) * values[i]))
        corrected[i] = reached
    return corrected


HEADS = ("tuner", "against", "pairs", "confirmed [points]", "p", "validated [points]", "p", "flights: fewer / more", "p", "lap [%]", "p")


def paired_cells(rows: Sequence[Paired]) -> list[list[str]]:
    """A table for people, with its header; empty without rows."""
    if not rows:
        return []
    body = [
        [
            row.tuner,
            row.against,
            str(row.pairs),
            *_cells(row.confirmed, 0),
            *_cells(row.validated, 0),
            f"{row.fewer} / {row.more}",
            _p(row.flights_p),
            *_cells(row.lap_time, 1),
        ]
        for row in rows
    ]
    return [list(HEADS), *body]


def _cells(difference: Difference, digits: int) -> tuple[str, str]:
    """A difference in per cent with its interval, and its p."""
    if not difference.pairs:
        return "-", "-"
    value = _signed(difference.value, digits)
    if difference.interval is None:
        return value, _p(difference.p)
    low, high = (_signed(bound, digits) for bound in difference.interval)
    return f"{value} [{low}, {high}]", _p(difference.p)


def _signed(share: float, digits: int) -> str:
    """A share in per cent with its sign; zero has none."""
    text = f"{100 * share:+.{digits}f}"
    return text[1:] if float(text) == 0 else text


def _p(value: float) -> str:
    return "<0.001" if value < 0.001 else f"{value:.3f}" if value < 0.1 else f"{value:.2f}"
