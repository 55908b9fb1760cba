"""Tuning runs on many races and seeds: python benchmarks/main_job.py --help

For each run: search flights, flights with re-flights, whether a controller was confirmed, its validation rate with interval, seconds.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from hotlap import tuners
from hotlap.core.success_rate import RELIABILITY
from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare
from hotlap.race.controllers import ControllerKind
from hotlap.race.race import Race
from hotlap.tuning.goal import Goal
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune
from hotlap.tuning.objective import Objective
from hotlap.worlds.built_in import BuiltIn

TABLE_I = ("circle-20", "circle-34", "drop-20", "flip-16", "spiral-53", "qualifier-20", "final-22")


def run(world: BuiltIn, race: Race, tuner: str, seed: int, budget: int, reliability: float) -> str:
    """One tuning run as a row of the table."""
    built, goal = tuners.build(tuner), Goal()
    scenario = scenario_for(prepare(race), built)
    objective, start = Objective(scenario, world), time.perf_counter()
    tuning = Tuning(built, scenario, TuningSettings(goal=goal, budget=budget, seed=seed, reliability=reliability))
    for _ in tune(objective, tuning):
        pass
    best, validation = tuning.best, tuning.validation
    if best is None or validation is None:
        return ""
    low, high = validation.interval
    confirmed = "yes" if best.confirmed else "no"
    rate = f"{100 * validation.rate:.0f} [{100 * low:.0f}, {100 * high:.0f}]"
    seconds = time.perf_counter() - start
    validations = tuning.validation_flights // validation.flights
    return f"| {race.name} | {seed} | {tuning.search_flights} | {tuning.flights} | {confirmed} | {rate} | {validations} | {seconds:.1f} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("races", nargs="*", default=TABLE_I)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--budget", type=int, default=1000)
    parser.add_argument("--reliability", type=float, default=RELIABILITY)
    parser.add_argument("--controller", type=ControllerKind, default=ControllerKind.MPC)
    parser.add_argument("--tuner", default=tuners.DEFAULT)
    arguments = parser.parse_args()
    world = BuiltIn()
    world.fly(scenario := prepare("circle-34"), scenario.space.first_guess(len(scenario.segments))[None], np.zeros(1, dtype=np.int64))
    print("| race | seed | search flights | flights | confirmed | validated % | validations | s |\n|---|---|---|---|---|---|---|---|")
    for race in (load_race(name).with_controller(arguments.controller) for name in arguments.races):
        for seed in range(arguments.seeds):
            print(run(world, race, arguments.tuner, seed, arguments.budget, arguments.reliability), flush=True)


if __name__ == "__main__":
    main()
