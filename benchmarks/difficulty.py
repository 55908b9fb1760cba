"""Difficulty of the built-in races: python benchmarks/difficulty.py [--flights 200] [--random 2000] [RACE ...]

For each race, over flights with different noise: completion and share of complete flights of the authors' default weights, and the
share of complete flights among random parameters, one set for all segments: uniform within the bounds, and uniform in logarithms.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from hotlap.core.records import Scores
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.files.descriptions import Kind, names
from hotlap.planning.preparation import prepare
from hotlap.reference.scenario import Scenario
from hotlap.tuning.scoring import score
from hotlap.worlds.built_in import BuiltIn


def fly(world: BuiltIn, scenario: Scenario, sets: np.ndarray, seed: int) -> Scores:
    """Scores of parameter sets of shape (B, K), each flown once with the same values in all segments."""
    parameters = np.repeat(sets[:, None], len(scenario.segments), axis=1)
    seeds = flight_seeds(seed, Stream.DEMONSTRATION, 0, len(sets))
    return score(world.fly(scenario, parameters, seeds), scenario.race.judge)


def describe(world: BuiltIn, race: str, flights: int, random: int) -> str:
    """One row of the table: completion and shares of complete flights [%] on a race."""
    scenario = prepare(race)
    space, rng = scenario.space, np.random.default_rng(0)
    default = fly(world, scenario, np.tile(space.default, (flights, 1)), 0)
    uniform = fly(world, scenario, rng.uniform(space.low, space.high, (random, space.size)), 1)
    logarithmic = fly(world, scenario, space.from_unit(rng.random((random, space.size))), 2)
    shares = [100 * scores.complete.mean() for scores in (default, uniform, logarithmic)]
    completion = 100 * default.completion.mean()
    return f"| {race} | {completion:.0f} | {shares[0]:.0f} | {shares[1]:.2f} | {shares[2]:.1f} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("races", nargs="*", default=names(Kind.RACE))
    parser.add_argument("--flights", type=int, default=200)
    parser.add_argument("--random", type=int, default=2000)
    arguments = parser.parse_args()
    world, start = BuiltIn(), time.perf_counter()
    print("| race | default: completion % | complete % | uniform: complete % | log-uniform: complete % |\n|---|---|---|---|---|")
    for race in arguments.races:
        print(describe(world, race, arguments.flights, arguments.random), flush=True)
    print(f"\n{time.perf_counter() - start:.0f} s, {world.numbers}")


if __name__ == "__main__":
    main()
