"""Which rule hands over controllers that hold, and what it costs: python benchmarks/holding.py --help

The default tuner from the learned first guess, where `hotlap tune` begins, and from the default weights, under several rules for what may
be handed over: so many re-flights, and so large a share of 200 more. Every result is then flown 400 times with noise that no rule has
seen, so that a rule does not judge itself. Runs are kept in `--out`/runs.jsonl; the same command goes on where it was interrupted.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hotlap import tuners
from hotlap.executor import spread
from hotlap.first_guess.guess import first_guess
from hotlap.objective import Objective
from hotlap.preparation import prepare
from hotlap.tuning import Tuning, TuningSettings, course_for, tune_together
from hotlap.worlds.built_in import BuiltIn

SUITE = ("circle-20", "circle-34", "drop-20", "flip-16", "spiral-53", "qualifier-20", "final-22")
AIRSIM = ("airsim-circle-34", "airsim-drop-20", "airsim-flip-16", "airsim-spiral-53", "airsim-qualifier-20", "airsim-final-21")
RULES = ((4, 0.0), (10, 0.0), (10, 0.8), (10, 0.9), (10, 0.95))  # re-flights, least share of 200 more
VALIDATION = 200  # flights, where a share of them is asked for
FLIGHTS, FIRST_SEED = 400, 10**12  # of each result; seeds that no search has met


@dataclass(frozen=True)
class Case:
    """Runs of the default tuner on one race under one rule.

    Attributes:
        race: its name.
        guess: where the runs begin, as in `--first-guess`.
        confirm: re-flights to be passed.
        reliability: least share of `VALIDATION` flights, or the search goes on.
        seeds: how many runs.
        budget: flights of each, re-flights included.
    """

    race: str
    guess: str
    confirm: int
    reliability: float
    seeds: int
    budget: int


def flown(cases: tuple[Case, ...]) -> Iterable[tuple[Case, list[dict[str, Any]]]]:
    """The runs of each case, with the share of fresh flights that complete."""
    for case in cases:
        course, world = prepare(case.race), BuiltIn()
        shared = {"budget": case.budget, "confirm": case.confirm, "reliability": case.reliability}
        validation = VALIDATION if case.reliability else 0
        on = course_for(course, tuners.build(tuners.DEFAULT))
        guess = first_guess(course, case.guess)
        runs = [
            Tuning(tuners.build(tuners.DEFAULT), on, TuningSettings(seed=seed, validation=validation, **shared), guess)
            for seed in range(case.seeds)
        ]
        for _ in tune_together(Objective(on, world), runs):
            pass
        results = np.concatenate([run.best.parameters[None] for run in runs if run.best is not None])
        seeds = FIRST_SEED + np.arange(FLIGHTS * len(runs), dtype=np.int64)
        fresh = Objective(course, world).fly(np.repeat(results, FLIGHTS, axis=0), seeds).completion >= 1
        shares = fresh.reshape(len(runs), FLIGHTS).mean(axis=1).tolist()
        yield (
            case,
            [
                {
                    "confirmed": run.best is not None and run.best.confirmed,
                    "search": run.search_flights,
                    "flights": run.flights,
                    "validation": run.validation_flights,
                    "share": share,
                }
                for run, share in zip(runs, shares, strict=True)
            ],
        )


def show(kept: list[dict[str, Any]]) -> None:
    """The table: of each rule, how often its results hold and how many flights it took; two of those for each race of `AIRSIM`."""
    print("| first guess | re-flights | of 200 more | suite: handed over | holds 95 % | flights | " + " | ".join(AIRSIM) + " |")
    print("|---|---|---|---|---|---|" + "---|" * len(AIRSIM))
    rules: dict[tuple[str, int, float], dict[str, list[dict[str, Any]]]] = {}
    for one in kept:
        rules.setdefault((one["guess"], one["confirm"], one["reliability"]), {})[one["race"]] = one["runs"]
    for (guess, confirm, reliability), runs in sorted(rules.items()):
        easy = [run for race in SUITE for run in runs.get(race, [])]
        cells = [f"{_confirmed(easy)} | {_holds(easy, 0.95)} | {_flights(easy)}"] if easy else ["| |"]
        cells += [f"{_holds(runs[race], 0.9)} / {_flights(runs[race])}" if race in runs else "" for race in AIRSIM]
        print(f"| {guess} | {confirm} | {100 * reliability:.0f} % | " + " | ".join(cells) + " |")


def _confirmed(runs: list[dict[str, Any]]) -> str:
    """Runs that handed a controller over as one that holds, in per cent."""
    return f"{100 * np.mean([run['confirmed'] for run in runs]):.0f}"


def _holds(runs: list[dict[str, Any]], share: float) -> str:
    """Runs whose result is confirmed and completes so large a share of fresh flights, in per cent."""
    return f"{100 * np.mean([run['confirmed'] and run['share'] >= share for run in runs]):.0f}"


def _flights(runs: list[dict[str, Any]]) -> str:
    """Median of all flights of a run, those of a rule's validations included."""
    return f"{np.median([run['flights'] + run['validation'] for run in runs]):.0f}"


def main() -> None:
    """Fly what is missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--budget", type=int, default=500)
    parser.add_argument("--guesses", nargs="+", default=["learned", "default"])
    parser.add_argument("--races", nargs="+", default=[*SUITE, *AIRSIM])
    parser.add_argument("--out", type=Path, default=Path("build/holding"))
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    path = arguments.out / "runs.jsonl"
    kept = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()] if path.exists() else []
    names = tuple(Case.__dataclass_fields__)
    done = {tuple(one[name] for name in names) for one in kept}
    asked = [
        Case(race, guess, confirm, reliability, arguments.seeds, arguments.budget)
        for guess in arguments.guesses
        for race in arguments.races
        for confirm, reliability in RULES
    ]
    missing = [(case,) for case in asked if tuple(asdict(case).values()) not in done]
    for number, (_, (case, runs)) in enumerate(spread(flown, missing, os.cpu_count() or 1), 1):
        kept.append({**asdict(case), "runs": runs})
        with path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(kept[-1]) + "\n")
        print(f"{number} of {len(missing)}: {case}", flush=True)
    show(kept)


if __name__ == "__main__":
    main()
