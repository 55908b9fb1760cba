"""Laps over MAVLink against a stand-in autopilot, on loopback: python benchmarks/mavlink.py --help

The race is circle-34 with 50 ms of dead time that the controller knows of; parameters are tuned first, or given. The stand-in flies the
built-in plant with 15 % less thrust than its file says, a battery that sags, and a link that loses, delays and shuffles messages. It owns
the clock, so that the figures are the same on every machine; only the last part, a link that is cut in real time, is not.
"""

from __future__ import annotations

import argparse
import platform
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import hotlap
from hotlap.analysis.log_frame import find_frame
from hotlap.analysis.log_judge import judge_log
from hotlap.api.flown import write_log
from hotlap.core.records import End
from hotlap.files.descriptions import load_parameters, load_race
from hotlap.logs.hotlap_csv import read_hotlap_csv
from hotlap.planning.preparation import parameters_for, prepare
from hotlap.real_flight import open_link
from hotlap.real_flight.flight import RealFlight
from hotlap.real_flight.mavlink.stand_in import StandIn, Weather
from hotlap.real_flight.settings import FlightSettings, Flown
from hotlap.real_flight.stand_in import StandInDrone
from hotlap.reference.scenario import Scenario

RACE = Path(__file__).with_name("mavlink_circle.toml")
WEATHER = Weather(loss=0.02, latency=0.002, jitter=0.004, position=0.005, velocity=0.02, attitude=0.002)
UPLINK = WEATHER.latency + WEATHER.jitter / 2  # s, a part of the dead time that is known
ABOVE, HIGH = 1.5, 50.0  # m of the start over the ground; from the second the drone hovers there already
WEAK = 0.2  # of the thrust: who has no more falls out of the geofence

Step = Callable[[StandIn], None]


class Bench:
    """Flies one scenario with one set of parameters.

    Args:
        scenario: what is flown.
        parameters: shape (S, K).
    """

    def __init__(self, scenario: Scenario, parameters: np.ndarray) -> None:
        self.scenario, self.parameters = scenario, parameters

    def fly(self, seed: int, share: float = 0.85, *, step: Step = lambda _: None, lockstep: bool = True, above: float = ABOVE):
        """One flight against a stand-in of its own: the flight, and the stand-in."""
        vehicle, start = self.scenario.race.vehicle, self.scenario.reference.position[0]
        drone = StandInDrone(vehicle, start - [0.0, 0.0, above], -1.5, share, vehicle.delay - UPLINK)
        if above > ABOVE:
            drone.hover(start)
        stand_in = StandIn("udpin:127.0.0.1:0", drone, WEATHER, seed, lockstep=lockstep, each_step=step)
        thread = threading.Thread(target=stand_in.serve, daemon=True)
        thread.start()
        try:
            name = f"mavlink:udpout:127.0.0.1:{stand_in.port}{'?clock=vehicle' if lockstep else ''}"
            link = open_link(name, self.scenario.race.controller.period)
            return RealFlight(link, self.scenario, self.parameters, FlightSettings(arm=True)).fly(), stand_in
        finally:
            if not lockstep:
                time.sleep(0.1)  # what was sent last is still on its way
            stand_in.stop()
            thread.join()

    def judge(self, flown: Flown):
        """The flight as `hotlap score` reads it from its log."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "flight.csv"
            write_log(path, flown.record.log(self.scenario.race.vehicle.rotor_count))
            log = read_hotlap_csv(path)
            return judge_log(log, self.scenario, find_frame(log, self.scenario))

    def hover_error(self, flown: Flown, stand_in: StandIn) -> float:
        """Largest error of the true height in the last second before the race [m]."""
        begun = flown.record.race_begun
        heights = [state[2] for moment, state in stand_in.path if begun - 1 <= moment <= begun]
        return float(np.abs(np.array(heights) - self.scenario.reference.position[0, 2]).max())


def outside(flown: Flown, stand_in: StandIn) -> int:
    """Setpoints that came while the drone, as it truly was, lay outside of the geofence."""
    return sum(flown.geofence.outside(told.state[:3]) for told in stand_in.setpoints if told.engaged)


def laps(bench: Bench, count: int) -> None:
    """Laps from the ground to the ground."""
    done, errors, heights, gains, strays = 0, [], [], [], 0
    for seed in range(count):
        flown, stand_in = bench.fly(seed)
        judged = bench.judge(flown)
        complete = judged.end[0] == End.FINISHED and flown.halt is None and not stand_in.drone.crashed
        done += bool(complete)
        errors.append(float(judged.mean_error[0]))
        heights.append(bench.hover_error(flown, stand_in))
        gains.append(flown.gain)
        strays += outside(flown, stand_in)
        print(f"  lap {seed + 1}: {judged.gates_passed[0]} gates, mean error {errors[-1]:.3f} m, {flown.halt or 'landed'}", flush=True)
    print(f"laps with all gates, landed: {done} of {count}; mean error {np.mean(errors):.3f} m")
    print(
        f"hover height with 15 % less thrust: at most {100 * max(heights):.1f} cm wrong; thrust found: {min(gains):.3f} to {max(gains):.3f}"
    )
    print(f"setpoints outside of the geofence in these laps: {strays}")


def hover(bench: Bench) -> None:
    """Height in hover with more thrust than the file says."""
    flown, stand_in = bench.fly(100, 1.15, step=stand_in_stops)
    print(f"hover height with 15 % more thrust: at most {100 * bench.hover_error(flown, stand_in):.1f} cm wrong; found: {flown.gain:.3f}")


def stand_in_stops(stand_in: StandIn) -> None:
    """It says no more when the race has begun: nothing further is wanted."""
    speed = np.linalg.norm(stand_in.drone.state[7:10])
    stand_in.silent = stand_in.silent or speed > 4


def fence(bench: Bench, count: int) -> None:
    """Drones that fall out of the geofence, each at another time."""
    sent, ended = 0, []
    for seed in range(count):
        began = []

        def weaken(stand_in: StandIn, began=began, seed=seed) -> None:
            if np.linalg.norm(stand_in.drone.state[7:10]) > 2 and not began:
                began.append(stand_in.now)
            if began and stand_in.now > began[0] + 0.7 * seed:
                stand_in.drone.thrust_share = WEAK

        flown, stand_in = bench.fly(200 + seed, step=weaken, above=HIGH)
        sent += outside(flown, stand_in)
        ended.append(str(flown.halt.reason) if flown.halt else "nothing")
    print(f"drones that lose their thrust, stopped by: {', '.join(sorted(set(ended)))}; setpoints outside of the geofence: {sent}")


def cut(bench: Bench, count: int) -> None:
    """A link that is cut, in real time: how long until the vehicle is asked to land, and until no setpoint comes."""
    asked, last = [], []
    for seed in range(count):
        moment = []

        def silence(stand_in: StandIn, moment=moment) -> None:
            if not moment and np.linalg.norm(stand_in.drone.state[7:10]) > 4:
                moment.append(stand_in.now)
                stand_in.silent = True

        flown, stand_in = bench.fly(300 + seed, step=silence, lockstep=False, above=HIGH)
        requests = [at for at, what in stand_in.requests if what == "land" and moment and at >= moment[0]]
        if not moment or not requests:
            print(f"  stopped before the link was cut: {flown.halt}")
            continue
        asked.append(requests[0] - moment[0])
        last.append(max(told.time for told in stand_in.setpoints) - moment[0])
    if asked:
        print(f"link cut in real time, {len(asked)} times: asked to land after at most {max(asked):.2f} s, last setpoint {max(last):.2f} s")


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--laps", type=int, default=20)
    parser.add_argument("--parameters", help="a study's folder or a file; else they are tuned")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if options.parameters is None:
            hotlap.tune(RACE, out=Path(folder) / "tuned")
        saved = load_parameters(options.parameters or Path(folder) / "tuned")
    race = load_race(RACE)
    scenario = prepare(race)
    bench = Bench(scenario, parameters_for(scenario, saved, str(options.parameters)))
    print(f"{race.name}, {1e3 * race.vehicle.delay:.0f} ms of dead time that is known, {platform.processor() or platform.machine()}")
    laps(bench, options.laps)
    hover(bench)
    fence(bench, 6)
    cut(bench, 5)


if __name__ == "__main__":
    main()
