"""Whether what was tuned in the built-in world flies elsewhere: python benchmarks/abroad.py --on rotorpy RACE..

Each race is tuned in the built-in world by the default tuner; then tuned and default weights fly with the same seeds in both worlds.
Tuned parameters are kept in `--out` and used again.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import hotlap
from hotlap import worlds
from hotlap.core.records import Flights
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.files.descriptions import PARAMETERS_FILE, load_parameters, load_race
from hotlap.planning.preparation import parameters_for, prepare
from hotlap.reference.scenario import Scenario
from hotlap.worlds.world import World

RACES = ("circle-34", "qualifier-20", "circle-20", "drop-20")


@dataclass(frozen=True)
class Row:
    """What became of some flights."""

    complete: int
    flights: int
    passed: float
    error: float
    largest: float

    @classmethod
    def of(cls, flights: Flights) -> Row:
        """Of a batch; errors in metres of complete flights."""
        complete = flights.gates_passed == len(flights.gate_times)
        if not complete.any():
            return cls(0, len(flights), share_passed(flights), np.nan, np.nan)
        errors = float(flights.mean_error[complete].mean()), float(flights.max_error[complete].max())
        return cls(int(complete.sum()), len(flights), share_passed(flights), *errors)

    def __str__(self) -> str:
        """As a part of a table."""
        return f"{self.complete:3d} of {self.flights:3d}  {100 * self.passed:5.1f} %  {self.error:6.3f} {self.largest:6.3f}"


def share_passed(flights: Flights) -> float:
    """Share of the gates that were passed, in the mean."""
    return float(flights.gates_passed.mean() / len(flights.gate_times))


def tuned_parameters(race: str, scenario: Scenario, out: Path) -> NDArray[np.float64]:
    """Parameters that the default tuner finds in the built-in world with seed 0, kept in a folder, shape (S, K)."""
    if not (out / PARAMETERS_FILE).exists():
        hotlap.tune(race, out=out)
    return parameters_for(scenario, load_parameters(out), str(out))


def fly(world: World, scenario: Scenario, parameters: NDArray[np.float64], flights: int) -> Flights:
    """Fly parameters, shape (S, K), with the seeds of `hotlap fly`."""
    seeds = flight_seeds(0, Stream.VALIDATION, 0, flights)
    return world.fly(scenario, np.tile(parameters[None], (flights, 1, 1)), seeds)


def main() -> None:
    """Print the table, a line as soon as it is there."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("races", nargs="*", default=RACES)
    parser.add_argument("--on", default="rotorpy")
    parser.add_argument("--flights", type=int, default=50)
    parser.add_argument("--out", type=Path, default=Path("build/abroad"))
    asked = parser.parse_args()
    print(f"{'race':14} {'weights':8} {'world':12} complete   gates   error [m], mean and largest of complete flights", flush=True)
    for name in asked.races:
        scenario = prepare(load_race(name))
        first = scenario.space.first_guess(len(scenario.segments))
        for weights, parameters in (("tuned", tuned_parameters(name, scenario, asked.out / name)), ("default", first)):
            for where in (worlds.DEFAULT, asked.on):
                row = Row.of(fly(worlds.build(where), scenario, parameters, asked.flights))
                print(f"{name:14} {weights:8} {where:12} {row}", flush=True)


if __name__ == "__main__":
    main()
