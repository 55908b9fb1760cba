"""How good first guesses are on a track that nobody learnt from: python benchmarks/first_guess.py [--jobs N]

For every race of the shipped training set that the drones of the two suites fly: each method learns from all other tracks, and guesses.
The guess is compared with what that race was tuned to, flown, and tuned from. Resumable; the tables go to standard output.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hotlap import tuners
from hotlap.analysis.learning import Lesson, lessons
from hotlap.analysis.lines_file import LinesFile
from hotlap.executor import spread
from hotlap.first_guess.features import OF_A_PIECE, PAPER
from hotlap.first_guess.guess import Method, guess_by, voted
from hotlap.first_guess.regression import Regression
from hotlap.first_guess.training_set import shipped
from hotlap.objective import Objective
from hotlap.preparation import prepare
from hotlap.seeds import Stream, flight_seeds
from hotlap.tuning import Tuning, TuningSettings, course_for, tune_together
from hotlap.worlds.built_in import BuiltIn

VEHICLES = {"default suite": "hummingbird, late", "airsim": "airsim"}
FLIGHTS, SEEDS, BUDGET = 32, 4, 100
TUNERS = ("guided_walk", "metropolis_hastings:paper")

METHODS: Mapping[str, Method | None] = {
    "default weights": None,
    "vote": voted,
    "median of the class": Regression("median"),
    "boosting, the paper's five": Regression(),
    **{f"boosting without {name}": Regression(features=tuple(other for other in PAPER if other != name)) for name in PAPER},
    "boosting, all features": Regression(features=tuple(OF_A_PIECE)),
    "random forest": Regression("forest"),
    "ridge": Regression("ridge"),
    "five nearest": Regression("nearest"),
}


def judge(lesson: Lesson) -> Iterator[dict[str, Any]]:
    """All methods on one race: error, share of complete flights, search flights of each tuner."""
    course = course_for(prepare(lesson.race), tuners.build(TUNERS[0]))
    known = next(race for race in shipped().races if race.track == lesson.race.track.name and race.vehicle == lesson.vehicle)
    training, segments = shipped().without(known.track), len(course.segments)
    guesses = {
        name: course.space.first_guess(segments) if method is None else guess_by(method, course, training)
        for name, method in METHODS.items()
    }
    world = BuiltIn(threads=1)
    objective = Objective(course, world)
    seeds = flight_seeds(0, Stream.DEMONSTRATION, 0, FLIGHTS)
    found: dict[str, Any] = {}
    for name, guess in guesses.items():
        completion = objective.fly(np.repeat(guess[None], FLIGHTS, axis=0), seeds).completion
        error = None if known.tuned is None else float(np.sqrt(np.mean((np.log(guess) - np.log(known.tuned)) ** 2)))
        found[name] = {"error": error, "complete": float((completion == 1).mean())}
    for tuner in TUNERS:
        settings = [TuningSettings(budget=BUDGET, seed=seed, confirm=4, reliability=0.0, validation=0) for seed in range(SEEDS)]
        runs = [(name, Tuning(tuners.build(tuner), course, one, guess)) for name, guess in guesses.items() for one in settings]
        for _ in tune_together(objective, [run for _, run in runs]):
            pass
        for name in METHODS:
            own = [run for other, run in runs if other == name]
            found[name][tuner] = [run.search_flights if run.best is not None and run.best.confirmed else None for run in own]
    yield found


def table(rows: list[dict[str, Any]]) -> Iterator[str]:
    """One suite: a line a method."""
    yield f"| method | error | complete | {' | '.join(f'{tuner}: confirmed, median' for tuner in TUNERS)} |\n|{'---|' * (3 + len(TUNERS))}"
    for name in METHODS:
        own = [row[name] for row in rows]
        errors = [entry["error"] for entry in own if entry["error"] is not None]
        cells = [name, f"{np.mean(errors):.2f}", f"{100 * np.mean([entry['complete'] for entry in own]):.0f} %"]
        for tuner in TUNERS:
            counts = [np.inf if count is None else count for entry in own for count in entry[tuner]]
            cells.append(f"{100 * np.mean(np.isfinite(counts)):.0f} %, {np.median(counts):.3g}")
        yield f"| {' | '.join(cells)} |"


def main() -> int:
    """Judge what is not judged yet, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("build/first-guess-study"))
    parser.add_argument("--jobs", type=int, default=0)
    options = parser.parse_args()
    known = {(race.track, race.vehicle) for race in shipped().races}
    asked = [one for one in lessons() if one.vehicle in VEHICLES.values() and (one.race.track.name, one.vehicle) in known]
    mark = shipped().fingerprint
    with LinesFile.opened(options.out) as kept:
        missing = [lesson for lesson in asked if f"{mark} {lesson.key}" not in kept.done]
        for lesson, found in spread(judge, missing, options.jobs):
            kept.add(f"{mark} {lesson.key}", found)
            print(f"{lesson.race.name} flown by {lesson.vehicle}", file=sys.stderr, flush=True)
        for suite, vehicle in VEHICLES.items():
            rows = [kept.done[f"{mark} {lesson.key}"] for lesson in asked if lesson.vehicle == vehicle]
            print(f"\n{suite}: {len(rows)} races, leave one track out\n", *table(rows), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
