"""How the default tuner does on races with real gates, and on those of other people: python benchmarks/real_gates.py [RACE ...] [--seeds N]

Every run is one of `hotlap tune` with its defaults (ten re-flights, at least 90 % of 200 more flights), from the learned first guess and
from the default weights; what counts is a controller that is confirmed within 200 search flights. Every result is flown 100 times more with
noise that no search has used. Runs are kept in `--out`; the same command continues where it was interrupted.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hotlap import tuners
from hotlap.analysis.resumable import digest_code
from hotlap.core.errors import PlanningError
from hotlap.core.success_rate import FLIGHTS, RELIABILITY
from hotlap.files.descriptions import load_race, names
from hotlap.files.kinds import Kind
from hotlap.first_guess.guess import first_guess
from hotlap.planning.preparation import prepare
from hotlap.race.controller_kind import ControllerKind
from hotlap.system.journal import Journal
from hotlap.system.process_pool import spread
from hotlap.system.processors import available
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune_together
from hotlap.tuning.objective import Objective
from hotlap.worlds.built_in import BuiltIn

GUESSES = ("learned", "default")
CONFIRM, SEARCH, BUDGET = 10, 200, 400  # re-flights; search flights that count; all flights of a run at most
FRESH, FIRST_SEED = 100, 2 * 10**12  # flights of each result; seeds that no search uses


@dataclass(frozen=True)
class Case:
    """Runs of the default tuner on one race from one first guess.

    Attributes:
        race: its name, or a file.
        guess: where the runs begin, as in `--first-guess`.
        seeds: how many runs.
        controller: which one flies; None: the race's.
    """

    race: str
    guess: str
    seeds: int
    controller: str | None = None


def fly(case: Case) -> Iterator[dict[str, Any]]:
    """The runs of a case, side by side."""
    began, world = time.perf_counter(), BuiltIn(threads=1)
    try:
        race = load_race(case.race)
        scenario = prepare(race if case.controller is None else race.with_controller(ControllerKind(case.controller)))
    except PlanningError as error:
        yield {"no_plan": str(error)}
        return
    judged, guess = scenario_for(scenario, tuners.build(tuners.DEFAULT)), first_guess(scenario, case.guess)
    settings = [
        TuningSettings(seed=seed, budget=BUDGET, confirm=CONFIRM, reliability=RELIABILITY, validation=FLIGHTS) for seed in range(case.seeds)
    ]
    runs = [Tuning(tuners.build(tuners.DEFAULT), judged, one, guess) for one in settings]
    for _ in tune_together(Objective(judged, world), runs):
        pass
    bests = [run.best for run in runs]
    known = [best.parameters if best else guess for best in bests]
    seeds = FIRST_SEED + np.arange(len(runs) * FRESH, dtype=np.int64)
    fresh = Objective(scenario, world).fly(np.repeat(known, FRESH, axis=0), seeds)
    shares = fresh.complete.reshape(len(runs), FRESH).mean(axis=1).tolist()
    found = [
        {
            "confirmed": bool(best and best.confirmed and run.search_flights <= SEARCH),
            "search": run.search_flights,
            "validated": run.validation.rate if run.validation else 0.0,
            "share": share,
        }
        for run, best, share in zip(runs, bests, shares, strict=True)
    ]
    reference = scenario.reference
    facts = {"duration": reference.duration, "top_speed": reference.max_speed, "planner": reference.cpu_time}
    yield {**facts, "default": _default(scenario, world), "wall": time.perf_counter() - began, "runs": found}


def _default(scenario: Any, world: BuiltIn) -> float:
    """Share of flights that the default weights complete."""
    weights = scenario.space.first_guess(len(scenario.segments))
    scores = Objective(scenario, world).fly(np.repeat(weights[None], FRESH, axis=0), FIRST_SEED + np.arange(FRESH, dtype=np.int64))
    return float(scores.complete.mean())


def row(case: Case, found: dict[str, Any]) -> str:
    """A line of the table."""
    if "no_plan" in found:
        return f"| {Path(case.race).stem} | {case.guess} | {found['no_plan']} | " + "| " * 7
    runs = found["runs"]
    confirmed = [run for run in runs if run["confirmed"]]
    share = f"{100 * np.mean([run['share'] for run in confirmed]):.1f}" if confirmed else "-"
    validated = f"{100 * np.mean([run['validated'] for run in confirmed]):.1f}" if confirmed else "-"
    flights = f"{np.median([run['search'] for run in confirmed]):.0f}" if confirmed else "-"
    cells = (
        Path(case.race).stem, case.guess, f"{found['duration']:.2f}", f"{found['top_speed']:.1f}", f"{100 * found['default']:.0f}",
        f"{100 * len(confirmed) / len(runs):.0f}", flights, validated, share, f"{found['wall'] / len(runs):.1f}",
    )  # fmt: skip
    return "| " + " | ".join(cells) + " |"


HEAD = (
    "| race | first guess | plan s | top speed m/s | default weights % | confirmed % | search flights | validated % | fresh % | s a run |\n"
    "|---|---|---|---|---|---|---|---|---|---|"
)


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly what is missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("races", nargs="*", metavar="RACE", default=[name for name in names(Kind.RACE) if name.startswith("real-")])
    parser.add_argument("--seeds", type=int, default=48)
    parser.add_argument("--guesses", nargs="+", default=GUESSES, choices=GUESSES)
    parser.add_argument("--controller", choices=[kind.value for kind in ControllerKind])
    parser.add_argument("--jobs", type=int, default=available())
    parser.add_argument("--out", type=Path, default=Path("build/real-gates"))
    options = parser.parse_args(arguments)
    cases = [Case(race, guess, options.seeds, options.controller) for race in options.races for guess in options.guesses]
    with Journal.opened(options.out, digest_code(Path(__file__))) as kept:
        missing = [case for case in cases if repr(case) not in kept.done]
        for count, (case, found) in enumerate(spread(fly, missing, options.jobs), 1):
            kept.add(repr(case), found)
            print(f"{count} of {len(missing)}: {case.race} from {case.guess}", file=sys.stderr, flush=True)
    print(HEAD)
    for case in cases:
        print(row(case, kept.done[repr(case)]))


if __name__ == "__main__":
    main()
