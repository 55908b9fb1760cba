"""Operations of a control step, and the share of the processor's peak that the flight core reaches: python benchmarks/operations.py

Counted are additions, multiplications, divisions, roots, comparisons and selections of the straight-line programs; loads and stores,
reference, noise and judge are not counted. The peak is that of independent multiply-adds, two operations each, in the same kind of number.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
from numba import njit

from hotlap.analysis.speed import RACE, machine_name
from hotlap.dynamics import models
from hotlap.flight import fly
from hotlap.flight.compile import translate
from hotlap.flight.lanes import as_numbers
from hotlap.flight.mpc import retract_stage
from hotlap.flight.numbers import COMPILE, Numbers, aligned_zeros, best_numbers
from hotlap.flight.riccati import backward_stage, forward_stage, terminal_stage
from hotlap.planning.preparation import prepare
from hotlap.reference.scenario import Scenario

ROUNDS, CHAINS, REPEATS = 20_000_000, 12, 5  # of the peak: iterations, independent chains
GROUPS = 16  # flights per lane


def operations(scenario: Scenario) -> list[tuple[str, int, int]]:
    """(part, operations, how often a control step runs it), with all sweeps."""
    settings = fly.settings_of(scenario)
    nodes, sweeps, steps = settings.nodes, settings.sweeps, settings.steps
    predictions = settings.predicted_periods + (settings.predicted_rest > 0)
    return [
        ("linearise a node", translate(models.linearised_node_map()).count(), nodes),
        ("last node", terminal_stage().count(), sweeps),
        ("backward stage", backward_stage().count(), nodes * sweeps),
        ("forward stage", forward_stage().count(), nodes * sweeps),
        ("move a node of the plan", retract_stage().count(), nodes + 1),
        ("predict", translate(models.node_map()).count(), predictions),
        ("step of the plant", translate(models.plant_step()).count(), steps),
    ]


def rate(scenario: Scenario, numbers: Numbers, *, stop_early: bool) -> float:
    """Control steps per second of one core; with `stop_early` sweeps that change nothing are omitted, as always in flight."""
    settings_of = fly.settings_of
    flights = GROUPS * numbers.lanes
    parameters = np.repeat(scenario.space.first_guess(len(scenario.segments))[None], flights, axis=0)
    try:
        fly.settings_of = lambda scenario: settings_of(scenario)._replace(stop_early=stop_early)
        best = 0.0
        for _ in range(REPEATS + 1):  # the first may compile
            start = time.process_time()
            _, effort = fly.fly_batch(scenario, parameters, np.arange(flights), numbers=numbers, threads=1)
            best = max(best, effort.lane_steps / (time.process_time() - start))
        return best
    finally:
        fly.settings_of = settings_of


def spinner(width: int) -> Callable[[np.ndarray, int], None]:
    """A compiled loop of twelve independent chains of multiply-adds."""

    @njit(**COMPILE)
    def spin(memory: np.ndarray, rounds: int) -> None:
        m = as_numbers(memory, width)
        x, y = m[12], m[13]
        a, b, c, d, e, f, g, h, i, j, k, l = m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11]
        for _ in range(rounds):
            a, b, c, d = a * x + y, b * x + y, c * x + y, d * x + y
            e, f, g, h = e * x + y, f * x + y, g * x + y, h * x + y
            i, j, k, l = i * x + y, j * x + y, k * x + y, l * x + y
        m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11] = a, b, c, d, e, f, g, h, i, j, k, l

    return spin


def peak(numbers: Numbers) -> float:
    """Operations per second of one core with independent multiply-adds only."""
    memory, spin = aligned_zeros((CHAINS + 2, numbers.lanes), numbers.dtype), spinner(numbers.width)
    memory[:CHAINS] = np.arange(1, CHAINS + 1)[:, None]
    memory[CHAINS], memory[CHAINS + 1] = 0.9999, 0.0001
    spin(memory, 1)
    best = 0.0
    for _ in range(REPEATS):
        start = time.process_time()
        spin(memory, ROUNDS)
        best = max(best, 2 * CHAINS * numbers.lanes * ROUNDS / (time.process_time() - start))
    return best


def main() -> None:
    """Print the tables."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    scenario = prepare(RACE)
    parts = operations(scenario)
    total = sum(count * times for _, count, times in parts)
    print(f"{machine_name()}; {RACE}\n\n| part | operations | times | share |\n|---|---|---|---|")
    for name, count, times in parts:
        print(f"| {name} | {count} | {times} | {100 * count * times / total:.1f} % |")
    print(f"| **a control step** | **{total}** | | |\n")
    print("| kind of number | all sweeps, steps/s | useful GFLOP/s | peak GFLOP/s | share | steps/s in flight |\n|---|---|---|---|---|---|")
    for numbers in dict.fromkeys((Numbers.FLOAT64X4, Numbers.FLOAT32X8, best_numbers())):
        steady, top = rate(scenario, numbers, stop_early=False), peak(numbers)
        useful, flown = steady * total, rate(scenario, numbers, stop_early=True)
        print(f"| {numbers} | {steady:,.0f} | {useful / 1e9:.1f} | {top / 1e9:.1f} | {100 * useful / top:.0f} % | {flown:,.0f} |")


if __name__ == "__main__":
    main()
