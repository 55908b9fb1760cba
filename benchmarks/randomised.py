"""Controllers tuned for vehicles that differ, by wall time: python benchmarks/randomised.py [RACE ...]

Each race is tuned as `hotlap tune RACE --randomise 0.1 --minutes 1` does it, as it is and with the observer and drag along the horizon;
then its result flies vehicles that no search has met, each drawn anew. Wall time counts, so nothing else should run; two processors are
enough. Runs are kept in `--out`; the same command continues.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import hotlap
from hotlap.analysis.resumable import digest_code
from hotlap.core.parameters import Parameters
from hotlap.core.success_rate import Validation
from hotlap.files.descriptions import load_race
from hotlap.race.race import Race
from hotlap.reference.scenario import Scenario
from hotlap.system.journal import Journal
from hotlap.tuning.goal import Goal
from hotlap.tuning.objective import Objective
from hotlap.worlds.built_in import BuiltIn

RACES = ("circle-34", "circle-20", "drop-20", "flip-16", "final-22", "qualifier-20", "spiral-53")
FLIGHTS, FIRST_SEED = 400, 4 * 10**12  # vehicles that judge a result; seeds that no search uses
HELD = 0.95
AS_IT_IS, OBSERVED = "as it is", "offset-free"


@dataclass(frozen=True)
class Case:
    """One run.

    Attributes:
        race: its name.
        controller: `AS_IT_IS` or `OBSERVED`.
        seed: of the tuning.
        spread: by how much vehicle parameters differ, as a share.
        minutes: of wall time.
    """

    race: str
    controller: str
    seed: int
    spread: float
    minutes: float


def ready(case: Case) -> Race:
    """The race, with its controller."""
    race = load_race(case.race)
    if case.controller == AS_IT_IS:
        return race
    settings = race.controller.model_copy(update={"offset_free": True, "reference_drag": True})
    return race.model_copy(update={"controller": settings})


def run(case: Case, folder: Path) -> dict[str, Any]:
    """Tune, and fly fresh vehicles."""
    begun = time.perf_counter()
    result = hotlap.tune(ready(case), seed=case.seed, randomise=case.spread, minutes=case.minutes, out=folder)
    waited = time.perf_counter() - begun
    validation = result.validation
    return {
        "confirmed": result.confirmed,
        "validated": None if validation is None else validation.rate,
        "fresh": judge(result.scenario, result.values, case.spread),
        "search_flights": result.result.search_flights,
        "flights": result.result.flights,
        "wall": waited,
    }


def judge(scenario: Scenario, parameters: Parameters, spread: float) -> int:
    """Flights of `FLIGHTS` that pass all gates, each with a vehicle of its own."""
    seeds = FIRST_SEED + np.arange(FLIGHTS, dtype=np.int64)
    flown = Objective(scenario, BuiltIn(), randomise=spread).fly(np.repeat(parameters[None], FLIGHTS, axis=0), seeds)
    return int(Goal().met(flown).sum())


def table(results: Mapping[Case, Mapping[str, Any]]) -> Iterator[str]:
    """A row for each race and controller: what each seed's result holds, in percent of fresh vehicles, and how long it took."""
    yield "| race | controller | holds of fresh vehicles, % | validated, % | search flights | wall s |"
    yield "|---|---|---|---|---|---|"
    for race, controller in dict.fromkeys((case.race, case.controller) for case in results):
        found = [result for case, result in results.items() if (case.race, case.controller) == (race, controller)]
        fresh = ", ".join(f"{100 * one['fresh'] / FLIGHTS:.1f}" for one in found)
        validated = ", ".join("-" if one["validated"] is None else f"{100 * one['validated']:.1f}" for one in found)
        flights, walls = ", ".join(str(one["search_flights"]) for one in found), ", ".join(f"{one['wall']:.0f}" for one in found)
        yield f"| {race} | {controller} | {fresh} | {validated} | {flights} | {walls} |"
    for controller in dict.fromkeys(case.controller for case in results):
        rates = [Validation(FLIGHTS, one["fresh"]).rate for case, one in results.items() if case.controller == controller]
        held = sum(rate >= HELD for rate in rates)
        yield f"\n{controller}: {held} of {len(rates)} runs hold at least {100 * HELD:.0f} % of fresh vehicles"


def main(arguments: Sequence[str] | None = None) -> None:
    """Run what is missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("races", nargs="*", metavar="RACE", default=list(RACES))
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1])
    parser.add_argument("--spread", type=float, default=0.1)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--out", type=Path, default=Path("build/randomised"))
    asked = parser.parse_args(arguments)
    several = [(race, controller) for race in asked.races for controller in (AS_IT_IS, OBSERVED)]
    cases = [Case(race, controller, seed, asked.spread, asked.minutes) for race, controller in several for seed in asked.seeds]
    with Journal.opened(asked.out, digest_code(Path(__file__))) as kept:
        missing = [case for case in cases if repr(case) not in kept.done]
        for count, case in enumerate(missing, 1):
            name = f"{case.race}-{case.controller.replace(' ', '_')}-{case.seed}-{case.spread:g}-{case.minutes:g}"
            kept.add(repr(case), run(case, asked.out / name))
            print(f"{count} of {len(missing)}: {name}", file=sys.stderr, flush=True)
        results = {case: kept.done[repr(case)] for case in cases}
    print("\n".join(table(results)))


if __name__ == "__main__":
    main()
