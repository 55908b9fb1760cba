"""Time of flights in the flight core, for every kind of number and controller: make benchmarks."""

from __future__ import annotations

import time

import numpy as np
import pytest

from hotlap.core.records import Flights
from hotlap.flight.fly import fly_batch
from hotlap.flight.numbers import Numbers, best_numbers
from hotlap.race.controllers import ControllerKind
from hotlap.reference.scenario import Scenario
from hotlap.worlds import BuiltIn


def fly(scenario: Scenario, flights: int, numbers: Numbers) -> tuple[Flights, float]:
    """Flights of the default parameters in one thread, and their number of control steps."""
    parameters = np.repeat(scenario.space.first_guess(len(scenario.segments))[None], flights, axis=0)
    flown, effort = fly_batch(scenario, parameters, np.arange(flights), numbers=numbers, threads=1)
    return flown, effort.useful_steps


@pytest.mark.parametrize("kind", ControllerKind)
@pytest.mark.parametrize("numbers", Numbers)
def test_flights(benchmark, scenario, numbers, kind):
    flown = Scenario(scenario.race.with_controller(kind), scenario.reference, scenario.segments)
    flights = 16 * numbers.lanes
    fly(flown, 1, numbers)  # compiles
    _, steps = benchmark.pedantic(fly, (flown, flights, numbers), rounds=5, warmup_rounds=1)
    benchmark.extra_info |= {"flights": flights, "microseconds a step": 1e6 * benchmark.stats["median"] / steps}


@pytest.mark.parametrize("flights", [1_000, 100_000])
def test_memory_and_cost_a_flight(benchmark, scenario, flights):
    """The smaller batch first: the memory of a process grows with the flights; the time per flight does not."""
    world = BuiltIn()
    world.prepare(scenario)
    parameters = np.repeat(scenario.space.first_guess(len(scenario.segments))[None], flights, axis=0)
    start = time.process_time()
    benchmark.pedantic(world.fly, (scenario, parameters, np.arange(flights)), rounds=1)
    cost = 1e6 * (time.process_time() - start) / flights
    benchmark.extra_info |= {"numbers": best_numbers(), "CPU microseconds a flight": cost, "MB in the process": resident()}
    assert resident() < 1000


def resident() -> float:
    """Peak memory of this process so far [MB]."""
    import resource  # noqa: PLC0415  not on every system
    import sys  # noqa: PLC0415

    unit = 1 if sys.platform == "darwin" else 1024  # bytes there, kilobytes elsewhere
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6
