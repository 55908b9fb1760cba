"""Quality of first guesses on tracks that are not in the training data: python benchmarks/first_guess.py left_out|unseen [--jobs N]

    left_out  every race of the shipped training set that the drones of the two suites fly: each method learns from all other tracks and
              makes a guess; the guess is compared with the parameters tuned on the race, flown, and used as the start of a search
    unseen    random tracks that are not in the training set: success rate of a guess as it is, and after few search flights

Resumable; the tables go to standard output.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hotlap import tuners
from hotlap.analysis.learning import Lesson, lessons, race_of
from hotlap.analysis.resumable import digest_code
from hotlap.core.errors import PlanningError
from hotlap.core.parameters import Parameters
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.first_guess.features import OF_A_PIECE, PAPER
from hotlap.first_guess.guess import Method, guess_by, voted
from hotlap.first_guess.regression import Regression
from hotlap.first_guess.training_set import shipped
from hotlap.planning.preparation import prepare
from hotlap.race.random_tracks import random_track
from hotlap.reference.scenario import Scenario
from hotlap.system.journal import Journal
from hotlap.system.process_pool import spread
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune_together
from hotlap.tuning.objective import Objective
from hotlap.worlds.built_in import BuiltIn

VEHICLES = {"default suite": "hummingbird, late", "airsim": "airsim"}
FLIGHTS, SEEDS, BUDGET = 32, 4, 100
UNSEEN = range(100, 120)  # seeds of tracks
UNSEEN_METHODS = ("default weights", "vote", "boosting, the paper's five")
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


def search(scenario: Scenario, guesses: Mapping[str, Parameters], asked: Sequence[str]) -> dict[str, dict[str, list[int | None]]]:
    """Number of search flights of each tuner from each guess, for each seed; None where no controller was confirmed."""
    found: dict[str, dict[str, list[int | None]]] = {name: {} for name in guesses}
    for tuner in asked:
        settings = [TuningSettings(budget=BUDGET, seed=seed, confirm=4, reliability=0.0, validation=0) for seed in range(SEEDS)]
        runs = [(name, Tuning(tuners.build(tuner), scenario, one, guess)) for name, guess in guesses.items() for one in settings]
        for _ in tune_together(Objective(scenario, BuiltIn(threads=1)), [run for _, run in runs]):
            pass
        for name in guesses:
            own = [run for other, run in runs if other == name]
            found[name][tuner] = [run.search_flights if run.best is not None and run.best.confirmed else None for run in own]
    return found


def complete(scenario: Scenario, guess: Parameters, flights: int) -> float:
    """Share of flights that pass every gate."""
    seeds = flight_seeds(0, Stream.DEMONSTRATION, 0, flights)
    scores = Objective(scenario, BuiltIn(threads=1)).fly(np.repeat(guess[None], flights, axis=0), seeds)
    return float((scores.completion == 1).mean())


def judge(lesson: Lesson) -> Iterator[dict[str, Any]]:
    """Error, share of complete flights and search flights of all methods on a race of the training set, trained on the other tracks."""
    scenario = scenario_for(prepare(lesson.race), tuners.build(TUNERS[0]))
    known = next(race for race in shipped().races if race.track == lesson.race.track.name and race.vehicle == lesson.vehicle)
    training = shipped().without(known.track)
    default = scenario.space.first_guess(len(scenario.segments))
    guesses = {name: default if method is None else guess_by(method, scenario, training) for name, method in METHODS.items()}
    found: dict[str, Any] = search(scenario, guesses, TUNERS)
    for name, guess in guesses.items():
        error = None if known.tuned is None else float(np.sqrt(np.mean((np.log(guess) - np.log(known.tuned)) ** 2)))
        found[name] |= {"error": error, "complete": complete(scenario, guess, FLIGHTS), "tuned": known.tuned is not None}
    yield found


def judge_unseen(lesson: Lesson) -> Iterator[dict[str, Any]]:
    """The same for guesses from the whole training set, on a track that is not in it."""
    try:
        scenario = scenario_for(prepare(lesson.race), tuners.build(TUNERS[0]))
    except PlanningError:
        yield {}
        return
    default = scenario.space.first_guess(len(scenario.segments))
    methods = {name: METHODS[name] for name in UNSEEN_METHODS}
    guesses = {name: default if method is None else guess_by(method, scenario, shipped()) for name, method in methods.items()}
    found: dict[str, Any] = search(scenario, guesses, TUNERS[:1])
    for name, guess in guesses.items():
        found[name]["complete"] = complete(scenario, guess, 200)
    yield found


def left_out(kept: Journal, jobs: int) -> Iterator[str]:
    """A table for each suite, with one row for each method."""
    known = {(race.track, race.vehicle) for race in shipped().races}
    asked = [one for one in lessons() if one.vehicle in VEHICLES.values() and (one.race.track.name, one.vehicle) in known]
    done = run(kept, "left_out", asked, judge, jobs)
    for suite, vehicle in VEHICLES.items():
        every = [done[lesson.key] for lesson in asked if lesson.vehicle == vehicle]
        rows = [row for row in every if row["default weights"]["tuned"]]
        yield f"\n{suite}: {len(rows)} races that could be tuned, of {len(every)}\n"
        yield f"| method | error | complete % | {' | '.join(TUNERS)} |\n|{'---|' * (3 + len(TUNERS))}"
        for name in METHODS:
            own = [row[name] for row in rows]
            error, share = np.mean([entry["error"] for entry in own]), 100 * np.mean([entry["complete"] for entry in own])
            counts = [[flights(count) for entry in own for count in entry[tuner]] for tuner in TUNERS]
            cells = [f"{100 * np.mean(np.isfinite(own)):.0f} / {np.median(own):.3g}" for own in counts]
            yield f"| {name} | {error:.2f} | {share:.0f} | {' | '.join(cells)} |"


def unseen(kept: Journal, jobs: int) -> Iterator[str]:
    """The table of success rates [%]: suites and methods by number of search flights."""
    asked = [
        Lesson(race_of(vehicle, random_track(seed), speed), vehicle)
        for vehicle, speed in (("hummingbird, late", 22.0), ("airsim", 18.0))
        for seed in UNSEEN
    ]
    done = run(kept, "unseen", asked, judge_unseen, jobs)
    heads = ("suite", "first guess", "tracks", "flies as it is", "holds as it is", "1 flight", "8 flights", f"{BUDGET} flights")
    yield f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}"
    for suite, vehicle in VEHICLES.items():
        rows = [row for lesson in asked if lesson.vehicle == vehicle and (row := done[lesson.key])]
        for name in UNSEEN_METHODS:
            shares = np.array([row[name]["complete"] for row in rows])
            counts = np.array([[flights(count) for count in row[name][TUNERS[0]]] for row in rows])
            cells = [shares.mean(), (shares >= 0.95).mean(), *((counts <= most).mean() for most in (1, 8, BUDGET))]
            yield f"| {suite} | {name} | {len(rows)} | {' | '.join(f'{100 * cell:.0f}' for cell in cells)} |"


def flights(count: int | None) -> float:
    """A number of search flights; infinite where no controller was confirmed."""
    return np.inf if count is None else count


def run(kept: Journal, part: str, asked: Sequence[Lesson], work: Callable[[Lesson], Iterator[Any]], jobs: int) -> dict[str, Any]:
    """Compute the results that are missing; all results by the keys of the races."""
    mark = f"{part} {shipped().fingerprint}"
    missing = [lesson for lesson in asked if f"{mark} {lesson.key}" not in kept.done]
    for count, (lesson, found) in enumerate(spread(work, missing, jobs), 1):
        kept.add(f"{mark} {lesson.key}", found)
        print(f"{count} of {len(missing)}: {lesson.race.name} flown by {lesson.vehicle}", file=sys.stderr, flush=True)
    return {lesson.key: kept.done[f"{mark} {lesson.key}"] for lesson in asked}


def main() -> int:
    """Run one part and print its tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parts = {"left_out": left_out, "unseen": unseen}
    parser.add_argument("part", choices=parts)
    parser.add_argument("--out", type=Path, default=Path("build/first-guess-study"))
    parser.add_argument("--jobs", type=int, default=0)
    options = parser.parse_args()
    with Journal.opened(options.out / options.part, digest_code(Path(__file__))) as kept:
        for line in parts[options.part](kept, options.jobs):
            print(line)
    return 0


if __name__ == "__main__":
    sys.exit(main())
