"""Success rate with uncertain vehicles over the speed of the reference: python benchmarks/robustness.py --help

The same track at several speeds, tuned with vehicle parameters that are off by up to 0, 10, 20 or 30 % (`--randomise`), then flown with
vehicle parameters that are off by up to each of these.
"""

from __future__ import annotations

import argparse

import numpy as np

from hotlap import tuners
from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare
from hotlap.reference.scenario import Scenario
from hotlap.tuning.goal import Goal
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune_together
from hotlap.tuning.objective import Objective
from hotlap.worlds.built_in import BuiltIn

SPREADS = (0.0, 0.1, 0.2, 0.3)
FLIGHTS, FIRST_SEED = 200, 10**12  # of each result with each spread; seeds that no search uses


def tuned(scenario: Scenario, world: BuiltIn, spread: float, seeds: int, budget: int) -> list[Tuning]:
    """Runs of the default tuner with vehicle parameters off by up to the spread [-]; results are not validated, and none is left out."""
    settings = [TuningSettings(budget=budget, seed=seed, reliability=0.0, validation=0, randomise=spread) for seed in range(seeds)]
    runs = [Tuning(tuners.build(tuners.DEFAULT), scenario, asked) for asked in settings]
    for _ in tune_together(Objective(scenario, world, randomise=spread), runs):
        pass
    return runs


def success(scenario: Scenario, world: BuiltIn, runs: list[Tuning], spread: float) -> float:
    """Share of complete flights over the results of all runs, with vehicle parameters off by up to the spread [-]."""
    parameters = np.concatenate([np.repeat(run.best.parameters[None], FLIGHTS, axis=0) for run in runs if run.best is not None])
    seeds = np.tile(FIRST_SEED + np.arange(FLIGHTS, dtype=np.int64), len(runs))
    return float(Goal().met(Objective(scenario, world, randomise=spread).fly(parameters, seeds)).mean())


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--race", default="circle-34")
    parser.add_argument("--speeds", type=float, nargs="+", default=[12.0, 16.0, 20.0, 26.0, 34.0], metavar="V_MAX")
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--budget", type=int, default=400)
    arguments = parser.parse_args()
    world, race = BuiltIn(), load_race(arguments.race)
    header = " | ".join(f"flown in {100 * spread:.0f} %" for spread in SPREADS)
    print(f"| v_max | lap s | tuned in | confirmed | search flights | {header} |\n|---|---|---|---|---|{'---|' * len(SPREADS)}")
    for speed in arguments.speeds:
        planning = race.planning.model_copy(update={"v_max": speed})
        scenario = scenario_for(prepare(race.model_copy(update={"planning": planning})), tuners.build(tuners.DEFAULT))
        for spread in SPREADS:
            runs = tuned(scenario, world, spread, arguments.seeds, arguments.budget)
            confirmed = [run for run in runs if run.best is not None and run.best.confirmed]
            middle = f"{np.median([run.search_flights for run in confirmed]):.0f}" if confirmed else "-"
            shares = " | ".join(f"{100 * success(scenario, world, runs, flown):.0f}" for flown in SPREADS)
            lap = scenario.reference.gate_times[-1]
            counts = f"{len(confirmed)} of {len(runs)} | {middle}"
            print(f"| {speed:g} | {lap:.2f} | {100 * spread:.0f} % | {counts} | {shares} |", flush=True)


if __name__ == "__main__":
    main()
