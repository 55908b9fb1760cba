"""Bench: how fast the flight core flies on this machine."""

from __future__ import annotations

import platform
import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters
from hotlap.flight.fly import Effort, fly_batch
from hotlap.flight.numbers import Numbers, best_numbers
from hotlap.planning.preparation import prepare
from hotlap.reference.scenario import Scenario
from hotlap.system.processors import available

RACE = "circle-34"
SPREAD = 0.5  # of the logarithm of each parameter around the default: what a tuner meets
LANE_FLIGHTS, SCALAR_FLIGHTS, RANDOM_FLIGHTS = 256, 24, 1000
REPEATS = 5
STAGES = 6  # that `measure` reports


@dataclass(frozen=True)
class Bench:
    """What was measured; rates are control steps per second of one core's time, everything included.

    Attributes:
        machine: name of the processor.
        threads: how many were used at once.
        lanes: kind of number with lanes.
        control_steps_per_second: {"float64": plain floats, "lanes": with lanes}, one core.
        microseconds_per_step: with lanes, one core.
        real_time_factor: flown seconds per second, with lanes, one core.
        useful_lane_share: share of lane steps that flew something, over flights most of which end early.
        flights_per_second: whole flights, all threads at once, by the clock on the wall.
        scaling: rate of all threads at once over that of one, by the clock on the wall.
    """

    machine: str
    threads: int
    lanes: str
    control_steps_per_second: dict[str, float]
    microseconds_per_step: float
    real_time_factor: float
    useful_lane_share: float
    flights_per_second: float
    scaling: float

    @property
    def gain(self) -> float:
        """Rate of the lanes over that of plain floats."""
        return self.control_steps_per_second["lanes"] / self.control_steps_per_second["float64"]

    def dump(self) -> dict[str, Any]:
        """As plain JSON."""
        return asdict(self)

    def lines(self) -> list[str]:
        """For people."""
        rates = self.control_steps_per_second
        return [
            f"{self.machine}, {self.threads} threads; race {RACE}, parameters scattered around the default",
            f"  float64           {rates['float64']:10,.0f} control steps/s a core",
            f"  {self.lanes:16s}  {rates['lanes']:10,.0f} control steps/s a core, {self.gain:.1f} times float64",
            f"  one step          {self.microseconds_per_step:10.2f} us, plant and judge included",
            f"  real time         {self.real_time_factor:10,.0f} times, on one core",
            f"  flights           {self.flights_per_second:10,.0f} a second on all threads, {self.scaling:.2f} times one thread",
            f"  useful lanes      {100 * self.useful_lane_share:10.0f} % of lane steps, random parameters",
        ]


def measure(report: Callable[[str], None]) -> Bench:
    """Measure for some seconds; the first time on a machine, compile for a minute.

    Args:
        report: called with a few words as each of `STAGES` begins.
    """
    scenario, lanes, threads = prepare(RACE), best_numbers(), available()
    rng = np.random.default_rng(0)
    scattered = _scatter(scenario, rng)
    for numbers in (Numbers.FLOAT64, lanes):
        report(f"compiling for {numbers}, once")
        _fly(scenario, scattered[:1], numbers)
    report(f"measuring {Numbers.FLOAT64}")
    scalar = _core_rate(scenario, scattered[:SCALAR_FLIGHTS], Numbers.FLOAT64)
    report(f"measuring {lanes}")
    rate = _core_rate(scenario, scattered, lanes)
    report(f"measuring whole flights on 1 and {threads} threads")
    single, together = (_flight_rate(scenario, scattered, lanes, count) for count in (1, threads))
    report("measuring how many lanes do useful work")
    low, high = scenario.space.low, scenario.space.high
    random = rng.uniform(low, high, (RANDOM_FLIGHTS, len(scenario.segments), len(low)))
    return Bench(
        machine=machine_name(),
        threads=threads,
        lanes=lanes.value,
        control_steps_per_second={"float64": scalar, "lanes": rate},
        microseconds_per_step=1e6 / rate,
        real_time_factor=rate * scenario.race.controller.period,
        useful_lane_share=_fly(scenario, random, lanes).useful_share,
        flights_per_second=together,
        scaling=together / single,
    )


def machine_name() -> str:
    """The processor's name, as far as the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, "") or platform.processor() or platform.machine()


def _scatter(scenario: Scenario, rng: np.random.Generator) -> Parameters:
    """Parameter sets around the default, the same for all segments."""
    space = scenario.space
    steps = SPREAD * space.log_step * rng.standard_normal((LANE_FLIGHTS, 1, space.size))
    return np.tile(space.clip(space.default * np.exp(steps)), (1, len(scenario.segments), 1))


def _fly(scenario: Scenario, parameters: Parameters, numbers: Numbers, threads: int = 1) -> Effort:
    seeds: NDArray[np.int64] = np.arange(len(parameters), dtype=np.int64)
    return fly_batch(scenario, parameters, seeds, numbers=numbers, threads=threads)[1]


def _core_rate(scenario: Scenario, parameters: Parameters, numbers: Numbers) -> float:
    """Useful control steps per second of processor time, the median of some repeats."""
    rates = []
    for _ in range(REPEATS):
        start = time.process_time()
        effort = _fly(scenario, parameters, numbers)
        rates.append(effort.useful_steps / (time.process_time() - start))
    return statistics.median(rates)


def _flight_rate(scenario: Scenario, parameters: Parameters, numbers: Numbers, threads: int) -> float:
    """Whole flights per second by the clock on the wall, the median of some repeats."""
    rates = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        _fly(scenario, parameters, numbers, threads)
        rates.append(len(parameters) / (time.perf_counter() - start))
    return statistics.median(rates)
