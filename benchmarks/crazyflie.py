"""Laps of a Crazyflie that stands in for one, by cflib itself, on loopback: python benchmarks/crazyflie.py --help

The stand-in flies the built-in plant by a controller of its own. It owns the clock, so that its figures are the same on every machine;
only the last part, a link that is cut in real time, is not.
"""

from __future__ import annotations

import argparse
import platform
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np

from hotlap.analysis.log_frame import find_frame
from hotlap.analysis.log_judge import judge_log
from hotlap.api.flown import write_log
from hotlap.core.records import End
from hotlap.files.descriptions import load_race
from hotlap.logs.hotlap_csv import read_hotlap_csv
from hotlap.planning.preparation import prepare
from hotlap.real_flight import open_link
from hotlap.real_flight.crazyflie.onboard import OnBoard
from hotlap.real_flight.crazyflie.stand_in import StandIn
from hotlap.real_flight.flight import RealFlight
from hotlap.real_flight.settings import FlightSettings, Flown
from hotlap.real_flight.stand_in import StandInDrone
from hotlap.reference.scenario import Scenario

RACE = Path(__file__).with_name("crazyflie_gates.toml")
NOISE = 0.005  # m
ABOVE = 0.5  # m of the start over the ground

Step = Callable[[StandIn], None]


def fly(
    scenario: Scenario, seed: int, option: str, *, lockstep: bool = True, step: Step = lambda _: None
) -> tuple[Flown, StandIn, list[str]]:
    """One flight from the ground to the ground: the flight, the stand-in, and what was said."""
    start = scenario.reference.position[0]
    drone = StandInDrone(scenario.race.vehicle, start - [0.0, 0.0, ABOVE], 0.3)
    stand_in = StandIn(OnBoard(drone), lockstep=lockstep, noise=NOISE, seed=seed, each_step=step)
    thread = threading.Thread(target=stand_in.serve, daemon=True)
    thread.start()
    lines: list[str] = []
    options = [one for one in (option, "clock=vehicle" if lockstep else "") if one]
    try:
        link = open_link(
            f"crazyflie:udp://127.0.0.1:{stand_in.port}{'?' if options else ''}{'&'.join(options)}", scenario.race.controller.period
        )
        flown = RealFlight(link, scenario, scenario.space.first_guess(1), FlightSettings(arm=True, wait=30.0), lines.append).fly()
        return flown, stand_in, lines
    finally:
        stand_in.stop()
        thread.join()


def away(scenario: Scenario, flown: Flown, stand_in: StandIn) -> np.ndarray:
    """Distances of the true path from the reference, at its times [m]."""
    begun, duration = flown.record.race_begun, scenario.reference.duration
    path = [(moment - begun, state[:3]) for moment, state in stand_in.path if begun <= moment <= begun + duration]
    times, places = np.array([moment for moment, _ in path]), np.array([place for _, place in path])
    return np.linalg.norm(places - scenario.reference.position_at(times), axis=1)


def laps(scenario: Scenario, count: int, option: str) -> None:
    """Laps one way or the other."""
    done, errors, strays = 0, [], 0
    for seed in range(count):
        flown, stand_in, lines = fly(scenario, seed, option)
        errors.append(away(scenario, flown, stand_in).mean() if flown.record.race_begun else np.nan)
        done += bool(flown.halt is None and not stand_in.board.drone.crashed and judged(scenario, flown))
        strays += sum(flown.geofence.outside(state[:3]) for _, state, _ in stand_in.setpoints)
        print(f"  lap {seed + 1}: mean error {errors[-1]:.3f} m, {flown.halt or 'landed'}", flush=True)
    name = option or "full states"
    print(f"{name}: {done} of {count} with all gates, landed; mean error {np.mean(errors):.3f} m; {strays} setpoints outside")
    print("".join(f"  {line}\n" for line in lines if "pieces" in line), end="")


def judged(scenario: Scenario, flown: Flown) -> bool:
    """Whether all gates were passed, by its log."""

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "flight.csv"
        write_log(path, flown.record.log(scenario.race.vehicle.rotor_count))
        log = read_hotlap_csv(path)
        return judge_log(log, scenario, find_frame(log, scenario)).end[0] == End.FINISHED


def cut(scenario: Scenario, count: int) -> None:
    """A link that is cut, in real time."""
    asked, last = [], []
    for seed in range(count):
        moment: list[float] = []

        def silence(stand_in: StandIn, moment: list[float] = moment) -> None:
            if not moment and np.linalg.norm(stand_in.board.drone.state[7:10]) > 0.5:
                moment.append(stand_in.now)
                stand_in.silent = True

        flown, stand_in, _ = fly(scenario, seed, "", lockstep=False, step=silence)
        land = [at for at, what in stand_in.requests if what == "land"]
        if not moment or not land:
            print(f"  stopped before the link was cut: {flown.halt}")
            continue
        asked.append(land[0] - moment[0])
        last.append(max(at for at, _, _ in stand_in.setpoints) - moment[0])
    if asked:
        print(f"link cut in real time, {len(asked)} times: asked to land after at most {max(asked):.2f} s, last setpoint {max(last):.2f} s")


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--race", default=str(RACE))
    parser.add_argument("--laps", type=int, default=5)
    options = parser.parse_args()
    scenario = prepare(load_race(options.race))
    print(f"{scenario.race.name}, planned lap {scenario.reference.duration:.2f} s, {platform.processor() or platform.machine()}")
    for option in ("", "trajectory"):
        laps(scenario, options.laps, option)
    cut(scenario, 5)


if __name__ == "__main__":
    main()
