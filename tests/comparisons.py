"""Runs of a comparison that nobody flew."""

from __future__ import annotations

import math

from hotlap.analysis.comparison import Run

TUNERS = ("gate_gp:default", "metropolis_hastings:tied", "cma_es:log", "random_search:paper")
LONG = "a-race-with-a-name-that-is-longer-than-a-phone-is-wide"


def make_run(tuner: str, race: str, seed: int, **changes) -> Run:
    """A run that confirmed a candidate after ten flights."""
    spent = {"budget": 200, "flights": 30, "search_flights": 10, "confirmed": True, "successes": 45, "validation": 50}
    worth = {"completion": 1.0, "cost": 5.0, "lap_time": 5.0, "tuner_time": 0.3, "curve": ((1, 0.2), (10, 1.0))}
    return Run(**{"race": race, "tuner": tuner, "seed": seed, **spent, **worth, **changes})


def make_comparison(seeds: int = 4) -> list[Run]:
    """Four tuners on three races: one where they differ, one where all do the same, and one that only some solve."""
    runs = [make_run(tuner, "all alike", seed) for tuner in TUNERS for seed in range(seeds)]
    for k, tuner in enumerate(TUNERS):
        for seed in range(seeds):
            flights, good = 5 * (k + 1) + seed, 48 - 5 * k - seed
            curve = ((1, 0.1), (flights // 2, 0.5), (flights, 1.0))
            runs.append(make_run(tuner, "all differ", seed, search_flights=flights, successes=good, curve=curve, lap_time=5 + 0.1 * k))
            solved, end = k < 2, 1.0 if k < 2 else 0.6
            worth = {"confirmed": solved, "successes": 50 * solved, "completion": end, "lap_time": 9.0 if solved else math.nan}
            runs.append(
                make_run(tuner, "a-race-with-a-name-that-is-longer-than-a-phone-is-wide", seed, **worth, curve=((1, 0.0), (20, end)))
            )
    return runs
