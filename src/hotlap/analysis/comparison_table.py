"""Comparison table: a row for each tuner on each race, and for each tuner over all races."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.analysis.comparison import Run
from hotlap.analysis.statistics import bootstrap_interval, means, medians, performance_profile, performance_ratios, quartiles
from hotlap.core.shown import Shown
from hotlap.core.success_rate import wilson_interval

Floats = NDArray[np.float64]
Interval = tuple[float, float]
Problem = tuple[str, int]
"""A race and a seed."""

CHECKPOINTS = (50, 200, 1000)  # flights at which completion is looked at
ALL = "all races"


@dataclass(frozen=True, repr=False)
class Row(Shown):
    """A tuner on a race; a run that never confirmed a candidate took infinitely many flights.

    Attributes:
        race: its name, or `ALL`.
        tuner: algorithm with preset.
        runs: how many.
        budget: flights of a run, re-flights included.
        success_rate: share of runs that confirmed a candidate.
        success_interval: Wilson's 95 % interval.
        validated_rate: share of successes in validation, mean over runs.
        validated_interval: 95 %, by resampling runs.
        flights_quartiles: of the search flights to the confirmed candidate, re-flights left out: the paper's count.
        flights_interval: 95 % of the median, by resampling runs.
        all_flights_median: the same with re-flights.
        completions: mean completion of the best candidate after each of `CHECKPOINTS` that is within the budget.
        completion_median: of the best candidate at the end.
        lap_time_median: [s] of the runs that count, see `comparable_laps`; NaN without any.
        lap_times: how many these are.
        tuner_time: [s] of the tuner itself for each flight.
        held: of each condition that was asked for, in words: share of successes, mean over runs, and 95 %, by resampling runs.
    """

    race: str
    tuner: str
    runs: int
    budget: int
    success_rate: float
    success_interval: Interval
    validated_rate: float
    validated_interval: Interval
    flights_quartiles: tuple[float, float, float]
    flights_interval: Interval
    all_flights_median: float
    completions: tuple[tuple[int, float], ...]
    completion_median: float
    lap_time_median: float
    lap_times: int
    tuner_time: float
    held: tuple[tuple[str, float, Interval], ...] = ()

    @property
    def flights_median(self) -> float:
        """Search flights of half of the runs."""
        return self.flights_quartiles[1]

    def dump(self) -> dict[str, Any]:
        """As plain values."""
        plain = asdict(self)
        completions = {str(when): value for when, value in self.completions}
        held = [{"change": change, "rate": rate, "low": low, "high": high} for change, rate, (low, high) in self.held]
        return {**plain, "completions": completions, "flights_median": self.flights_median, "held": held}


def rows_of(runs: Sequence[Run]) -> list[Row]:
    """A row for each race and tuner, in the order in which they first occur."""
    groups: dict[tuple[str, str], list[Run]] = {}
    for run in runs:
        groups.setdefault((run.race, run.tuner), []).append(run)
    laps = comparable_laps(runs)
    return [summarise(race, tuner, group, laps) for (race, tuner), group in groups.items()]


def overall(runs: Sequence[Run]) -> list[Row]:
    """A row for each tuner over all its runs, the best first: by success, then by median flights."""
    groups: dict[str, list[Run]] = {}
    for run in runs:
        groups.setdefault(run.tuner, []).append(run)
    laps = comparable_laps(runs)
    rows = [summarise(ALL, tuner, group, laps) for tuner, group in groups.items()]
    return sorted(rows, key=lambda row: (-row.success_rate, row.flights_median, -row.validated_rate))


def comparable_laps(runs: Sequence[Run]) -> frozenset[Problem]:
    """The races, each with a seed, that all tuners solved and have a lap time for: others' lap times are of other races or of luck."""
    names = {run.tuner for run in runs}
    solved: dict[Problem, set[str]] = {}
    for run in runs:
        if run.confirmed and math.isfinite(run.lap_time):
            solved.setdefault((run.race, run.seed), set()).add(run.tuner)
    return frozenset(problem for problem, by in solved.items() if by == names)


def summarise(race: str, tuner: str, runs: Sequence[Run], laps: Container[Problem] | None = None) -> Row:
    """One row.

    Args:
        race: its name, or `ALL`.
        tuner: algorithm with preset.
        runs: at least one.
        laps: races and seeds whose lap times count; None: all.
    """
    confirmed, validated = sum(run.confirmed for run in runs), np.array([run.validated for run in runs])
    budget, flights = max(run.budget for run in runs), search_flights(runs)
    times = [run.lap_time for run in runs if math.isfinite(run.lap_time) and (laps is None or (run.race, run.seed) in laps)]
    whole = np.array([run.flights if run.confirmed else np.inf for run in runs])
    at = [(when, float(np.mean([run.completion_at(when) for run in runs]))) for when in CHECKPOINTS if when <= budget]
    return Row(
        race=race,
        tuner=tuner,
        runs=len(runs),
        budget=budget,
        success_rate=confirmed / len(runs),
        success_interval=wilson_interval(confirmed, len(runs)),
        validated_rate=float(validated.mean()),
        validated_interval=bootstrap_interval(validated, means),
        flights_quartiles=quartiles(flights),
        flights_interval=bootstrap_interval(flights, medians),
        all_flights_median=quartiles(whole)[1],
        completions=tuple(at),
        completion_median=float(np.median([run.completion for run in runs])),
        lap_time_median=float(np.median(times)) if times else float("nan"),
        lap_times=len(times),
        tuner_time=sum(run.tuner_time for run in runs) / max(sum(run.flights for run in runs), 1),
        held=_held(runs),
    )


def _held(runs: Sequence[Run]) -> tuple[tuple[str, float, Interval], ...]:
    """What runs hold under, where all of them were asked for the same."""
    rows = []
    for cells in zip(*(run.held for run in runs), strict=False):
        if len({name for name, _, _ in cells}) == 1:
            rates = np.array([successes / flights for _, successes, flights in cells])
            rows.append((cells[0][0], float(rates.mean()), bootstrap_interval(rates, means)))
    return tuple(rows)


def search_flights(runs: Sequence[Run]) -> Floats:
    """Of each run, infinite where no candidate was confirmed."""
    return np.array([run.search_flights if run.confirmed else np.inf for run in runs])


def profiles(runs: Sequence[Run], factors: Floats) -> Mapping[str, Floats]:
    """Performance profiles: for each tuner, the share of (race, seed) that it solved within a factor of the fastest tuner there.

    Args:
        runs: of all tuners; a problem that some tuner has not flown is left out.
        factors: shape (F,), each at least 1.

    Returns:
        Shape (F,) for each tuner.
    """
    flights = {(run.tuner, run.race, run.seed): run.search_flights if run.confirmed else np.inf for run in runs}
    names = list(dict.fromkeys(run.tuner for run in runs))
    met = dict.fromkeys((run.race, run.seed) for run in runs)
    problems = [problem for problem in met if all((name, *problem) in flights for name in names)]
    if not problems:
        return {name: np.zeros(len(factors)) for name in names}
    costs = np.array([[flights[name, *problem] for problem in problems] for name in names])
    shares = performance_profile(performance_ratios(costs), factors)
    return dict(zip(names, shares, strict=True))


def completion_band(
    runs: Sequence[Run], flights: NDArray[np.int64], lower: float = 0.25, upper: float = 0.75
) -> tuple[Floats, Floats, Floats]:
    """Quantile, median and quantile over runs of the best candidate's completion, each of shape (F,), after so many flights."""
    values = np.array([[run.completion_at(int(when)) for when in flights] for run in runs])
    return np.quantile(values, lower, axis=0), np.median(values, axis=0), np.quantile(values, upper, axis=0)


COMPLETIONS = "completion % at"  # with the numbers of flights behind it

COLUMNS: Mapping[str, Callable[[Row], str]] = {
    "race": lambda row: row.race,
    "tuner": lambda row: row.tuner,
    "runs": lambda row: str(row.runs),
    "confirmed %": lambda row: _share(row.success_rate, row.success_interval),
    "validated %": lambda row: _share(row.validated_rate, row.validated_interval),
    "flights [quartiles]": lambda row: (
        f"{_count(row.flights_median)} [{_count(row.flights_quartiles[0])}, {_count(row.flights_quartiles[2])}]"
    ),
    "with re-flights": lambda row: _count(row.all_flights_median),
    COMPLETIONS: lambda row: " / ".join(f"{100 * value:.0f}" for _, value in row.completions),
    "lap s (runs)": lambda row: f"{row.lap_time_median:.2f} ({row.lap_times})" if row.lap_times else "-",
    "ms/flight": lambda row: f"{1e3 * row.tuner_time:.2g}",
}


def cells_of(rows: Sequence[Row]) -> list[list[str]]:
    """A table for people, with its header; at least one row."""
    longest = max((row.completions for row in rows), key=len)
    at = " / ".join(str(when) for when, _ in longest)
    columns = {f"{name} {at}" if name is COMPLETIONS else name: show for name, show in COLUMNS.items() if at or name is not COMPLETIONS}
    return [list(columns), *([show(row) for show in columns.values()] for row in rows)]


def held_cells_of(rows: Sequence[Row]) -> list[list[str]]:
    """A table of what is held under each condition, in %, with its header; empty where nobody asked."""
    changes = list(dict.fromkeys(change for row in rows for change, _, _ in row.held))
    if not changes:
        return []
    known = [{change: _share(rate, interval) for change, rate, interval in row.held} for row in rows]
    body = [[row.race, row.tuner, *(shares.get(change, "-") for change in changes)] for row, shares in zip(rows, known, strict=True)]
    return [["race", "tuner", *(f"{change} %" for change in changes)], *body]


def markdown(cells: Sequence[Sequence[str]]) -> str:
    """A table of cells as Markdown."""
    header, *body = cells
    lines = [f"| {' | '.join(cells)} |" for cells in (header, ["---"] * len(header), *body)]
    return "\n".join(lines) + "\n"


def _share(share: float, interval: Interval) -> str:
    return f"{100 * share:.0f} [{100 * interval[0]:.0f}, {100 * interval[1]:.0f}]"


def _count(value: float) -> str:
    return f"{value:.0f}" if math.isfinite(value) else "-"
