"""Success rate of accepted controllers under several rules, and their cost in flights: python benchmarks/holding.py --help

The default tuner from the learned first guess, where `hotlap tune` begins, and from the default weights, with several rules for accepting a
controller: a number of re-flights, and a least validation rate. Every result is then flown 400 times with noise that no rule has used, so
that a rule is not evaluated by its own flights. Results are kept in `--out`; the same command continues where it was interrupted.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from comparison import TABLE_I

from hotlap import tuners
from hotlap.analysis.resumable import digest_code
from hotlap.core.success_rate import FLIGHTS
from hotlap.first_guess.guess import first_guess
from hotlap.planning.preparation import prepare
from hotlap.system.journal import Journal
from hotlap.system.process_pool import spread
from hotlap.system.processors import available
from hotlap.tuners.renamed import current_name
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune_together
from hotlap.tuning.objective import Objective
from hotlap.worlds.built_in import BuiltIn

AIRSIM = ("airsim-circle-34", "airsim-drop-20", "airsim-flip-16", "airsim-spiral-53", "airsim-qualifier-20", "airsim-final-21")
GUESSES = ("learned", "default")
RULES = ((4, 0.0), (10, 0.0), (10, 0.8), (10, 0.9), (10, 0.95))  # re-flights, least validation rate
FRESH, FIRST_SEED = 400, 10**12  # flights of each result; seeds that no search uses
HOLDS, HOLDS_AIRSIM = 0.95, 0.9  # least success rate over the fresh flights


@dataclass(frozen=True)
class Case:
    """Runs of a tuner on one race under one rule.

    Attributes:
        race: its name.
        guess: where the runs begin, as in `--first-guess`.
        confirm: number of re-flights that must succeed.
        reliability: least validation rate, below which the search goes on; 0: no validation.
        seeds: how many runs.
        budget: flights of each run at most, re-flights included.
        tuner: its name.
    """

    race: str
    guess: str
    confirm: int
    reliability: float
    seeds: int
    budget: int
    tuner: str = tuners.DEFAULT


def fly(case: Case) -> Iterator[list[dict[str, Any]]]:
    """The runs, each with the success rate of its result over fresh flights."""
    scenario, world = prepare(case.race), BuiltIn(threads=1)
    judged, guess = scenario_for(scenario, tuners.build(case.tuner)), first_guess(scenario, case.guess)
    shared = {"budget": case.budget, "confirm": case.confirm, "reliability": case.reliability}
    settings = [TuningSettings(seed=seed, validation=FLIGHTS if case.reliability else 0, **shared) for seed in range(case.seeds)]
    runs = [Tuning(tuners.build(case.tuner), judged, one, guess) for one in settings]
    for _ in tune_together(Objective(judged, world), runs):
        pass
    results = [run.best for run in runs if run.best is not None]
    parameters = np.repeat([result.parameters for result in results], FRESH, axis=0)
    fresh = Objective(scenario, world).fly(parameters, FIRST_SEED + np.arange(len(parameters), dtype=np.int64))
    shares = fresh.complete.reshape(len(runs), FRESH).mean(axis=1).tolist()
    yield [
        {
            "confirmed": result.confirmed,
            "search": run.search_flights,
            "flights": run.flights,
            "validation": run.validation_flights,
            "share": share,
        }
        for run, result, share in zip(runs, results, shares, strict=True)
    ]


class Kept(Journal):
    """Results by case; those recorded under a tuner's name of then count for its name of today."""

    def _parsed(self, plain: Any) -> tuple[str, Any]:
        return re.sub(r"(?<=tuner=')[^']*", lambda found: current_name(found[0]), plain["key"]), plain["value"]


def shown(runs: Sequence[dict[str, Any]], least: float) -> str:
    """Runs that confirm a result with at least this success rate over the fresh flights [%] / median of all flights of a run."""
    holding = np.mean([run["confirmed"] and run["share"] >= least for run in runs])
    return f"{100 * holding:.0f} / {np.median([run['flights'] + run['validation'] for run in runs]):.0f}"


def main() -> None:
    """Fly what is missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--budget", type=int, default=500)
    parser.add_argument("--races", nargs="+", default=(*TABLE_I, *AIRSIM), choices=(*TABLE_I, *AIRSIM), metavar="RACE")
    parser.add_argument("--guesses", nargs="+", default=GUESSES, choices=GUESSES)
    parser.add_argument("--jobs", type=int, default=available())
    parser.add_argument("--out", type=Path, default=Path("build/holding"))
    options = parser.parse_args()
    rules = [(guess, *rule) for guess in options.guesses for rule in RULES]
    cases = {(race, rule): Case(race, *rule, options.seeds, options.budget) for race in options.races for rule in rules}
    with Kept.opened(options.out, digest_code(Path(__file__))) as kept:
        missing = [case for case in cases.values() if repr(case) not in kept.done]
        for count, (case, runs) in enumerate(spread(fly, missing, options.jobs), 1):
            kept.add(repr(case), runs)
            print(f"{count} of {len(missing)}: {case.race} from {case.guess}", file=sys.stderr, flush=True)
    columns = {"default suite": ([race for race in TABLE_I if race in options.races], HOLDS)}
    columns |= {race: ([race], HOLDS_AIRSIM) for race in AIRSIM if race in options.races}
    columns = {name: column for name, column in columns.items() if column[0]}
    print("| first guess | re-flights | of 200 more | " + " | ".join(columns) + " |\n|---|---|---|" + "---|" * len(columns))
    for rule in rules:
        guess, confirm, reliability = rule
        cells = [shown([run for race in races for run in kept.done[repr(cases[race, rule])]], least) for races, least in columns.values()]
        print(f"| {guess} | {confirm} | {100 * reliability:.0f} % | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
