"""Does home predict abroad? Success in the built-in world against success elsewhere: python benchmarks/home_and_abroad.py --help

Each race is tuned at home by the default tuner, once with its vehicle as the race has it and, where it is known what a world makes of that
vehicle, once with that description: plan, controller and what it knows stay the same. The default weights and the tuned ones are flown at
home and in the other world, with the same noise, which no search has used. Betaflight's rate loop and mixer are known (`as_flown`); for
other worlds `--vehicle` says it, a TOML file with keys of a quadrotor that differ (mixer, rate_loop, motor_time, ...): `--vehicle
airsim=FILE` for all races of a world, or `--vehicle airsim/split-s=FILE` for one. Flights are kept in `--out`; the same command continues.
To try it without another simulator: python benchmarks/home_and_abroad.py --pairs circle-34@home_and_abroad.Plant --flights 10
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from hotlap import tuners, worlds
from hotlap.analysis.resumable import digest_code
from hotlap.core.errors import InputError
from hotlap.core.parameters import Parameters
from hotlap.core.success_rate import Validation
from hotlap.files.descriptions import load_race
from hotlap.files.error_messages import check
from hotlap.first_guess.guess import first_guess
from hotlap.planning.preparation import prepare
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import Race
from hotlap.reference.scenario import Scenario
from hotlap.reproduce.real_world import flown_by
from hotlap.system.journal import Journal
from hotlap.tuning.loop import Tuning, TuningSettings, scenario_for, tune
from hotlap.tuning.objective import Objective
from hotlap.worlds.betaflight.gains import as_flown
from hotlap.worlds.plant_simulator import PlantSimulator
from hotlap.worlds.world import World

HOME = "built-in"
DEFAULT_SUITE, AIRSIM = ("circle-20", "circle-34", "drop-20", "qualifier-20"), ("airsim-circle-34", "airsim-drop-20", "airsim-qualifier-20")
RACES = (*DEFAULT_SUITE, *AIRSIM, "split-s")
WORLDS = ("rotorpy", "betaflight", "crazyflow")
PAIRS = (*((race, world) for world in WORLDS for race in RACES), ("lsy-level0", "crazyflow"))
FIRST_SEED = 4 * 10**12  # of flights that no search has flown
CHUNK = 5  # flights that are kept together
HOLDS = 0.95
NEAR = 10  # points between home and abroad
PLAIN, DESCRIBED = "as the race has it", "as it is there"

Description = Callable[[Quadrotor], Quadrotor]  # a vehicle as a race has it -> as a world flies it
KNOWN: Mapping[str, Description] = {"betaflight": as_flown}


class Plant(PlantSimulator):
    """The built-in world's plant, for `RACE@home_and_abroad.Plant`: home must predict it."""

    def __init__(self, scenario: Scenario, instance: int, argument: str = "") -> None:
        del instance, argument
        floor = -np.inf if scenario.race.track.floor is None else scenario.race.track.floor
        super().__init__(scenario.race.vehicle, scenario.race.control_model, floor)


@dataclass(frozen=True)
class Case:
    """One race, one world.

    Attributes:
        race: its name, or a file.
        world: where it is flown besides at home.
        description: what the world makes of the vehicle; None: the vehicle as the race has it.
    """

    race: str
    world: str
    description: Description | None = None

    @property
    def vehicle(self) -> str:
        """How the vehicle is described at home, in words."""
        return PLAIN if self.description is None else DESCRIBED

    @property
    def at_home(self) -> Race:
        """The race as it is flown at home."""
        race = load_race(self.race)
        if self.description is None:
            return race
        return flown_by(race, self.description(race.vehicle))


@dataclass(frozen=True)
class Row:
    """Flights of a case by parameters ("default", "tuned") and place (home, world).

    Attributes:
        case: what was flown.
        passed: flights that passed every gate.
        errors: mean and largest distance from the reference [m] of those, the largest of the worst flight; NaN where none did.
    """

    case: Case
    passed: Mapping[tuple[str, str], Validation]
    errors: Mapping[tuple[str, str], tuple[float, float]]

    def apart(self, label: str) -> float:
        """Points between home and abroad."""
        return 100 * abs(self.passed[label, HOME].rate - self.passed[label, self.case.world].rate)

    @property
    def tuned_is_better(self) -> bool:
        """Whether tuned parameters beat the default ones there: more flights pass, or as many with smaller errors, mean and largest."""
        tuned, default = ((self.passed[label, self.case.world], self.errors[label, self.case.world]) for label in ("tuned", "default"))
        if tuned[0].rate != default[0].rate:
            return tuned[0].rate > default[0].rate
        return tuned[1][0] <= default[1][0] and tuned[1][1] <= default[1][1]


class Study:
    """What has been tuned and flown, and what is still to be.

    Args:
        kept: results so far.
        flights: of each set of parameters in each place.
        instances: simulators side by side.
    """

    def __init__(self, kept: Journal, flights: int, instances: int) -> None:
        self._kept, self._flights, self._instances = kept, flights, instances
        self._home = worlds.build(HOME)

    def row(self, case: Case) -> Row:
        """Tune, and fly everywhere, as far as that is not done yet."""
        home, abroad = prepare(case.at_home), prepare(case.race)
        passed, errors = {}, {}
        for label in ("default", "tuned"):  # a world that is not there is found out before anything is tuned
            parameters = self._tuned(case, home) if label == "tuned" else first_guess(home, label)
            for place, scenario in ((HOME, home), (case.world, abroad)):
                found = self._flown(case, place, label, scenario, parameters)
                complete = [flight for flight in found if flight[0]]
                passed[label, place] = Validation(len(found), len(complete))
                errors[label, place] = (np.nan, np.nan)
                if complete:
                    errors[label, place] = float(np.mean([mean for _, mean, _ in complete])), max(most for _, _, most in complete)
        return Row(case, passed, errors)

    def _tuned(self, case: Case, home: Scenario) -> Parameters:
        """Parameters of the default tuner, from the learned first guess."""
        key = f"tuned {case.race} {_digest(home.race.model_dump_json())}"
        if key not in self._kept.done:
            tuner = tuners.build(tuners.DEFAULT)
            judged = scenario_for(home, tuner)
            run = Tuning(tuner, judged, TuningSettings(confirm=10), first_guess(judged))
            for _ in tune(Objective(judged, self._home), run):
                pass
            assert run.best is not None
            self._kept.add(key, run.best.parameters.tolist())
            _say(f"{case.race} tuned, vehicle {case.vehicle}, {run.flights} flights")
        return np.array(self._kept.done[key])

    def _flown(self, case: Case, place: str, label: str, scenario: Scenario, parameters: Parameters) -> list[tuple[bool, float, float]]:
        """Whether each flight passed every gate, and its mean and largest error [m]."""
        found = []
        for first in range(0, self._flights, CHUNK):
            seeds = FIRST_SEED + np.arange(first, min(first + CHUNK, self._flights), dtype=np.int64)
            decides = _digest(scenario.race.model_dump_json(), scenario.reference.table.tobytes(), parameters.tobytes())
            key = f"{case.race} in {place}, {label}, from {first}, {len(seeds)} flights #{decides}"
            if key not in self._kept.done:
                world = self._home if place == HOME else world_of(place, self._instances)
                scores = Objective(scenario, world).fly(np.repeat(parameters[None], len(seeds), axis=0), seeds)
                self._kept.add(key, [x.tolist() for x in (scores.complete, scores.mean_error.round(4), scores.max_error.round(4))])
                _say(f"{case.race} in {place}, {label}: {first + len(seeds)} of {self._flights} flights")
            found += zip(*self._kept.done[key], strict=True)
        return found


@cache
def world_of(name: str, instances: int) -> World:
    """A world, which stays open."""
    return worlds.build(name, instances)


def table(rows: Sequence[Row]) -> Iterator[str]:
    """Lines of the table: successes in per cent with their interval; mean and largest errors in metres."""
    yield "| race | world | vehicle at home | default: home % | there % | there m | tuned: home % | there % | home m | there m |"
    yield "|---" * 10 + "|"
    for row in rows:
        world = row.case.world
        cells = [_percent(row.passed["default", HOME]), _percent(row.passed["default", world]), _metres(row.errors["default", world])]
        cells += [_percent(row.passed["tuned", HOME]), _percent(row.passed["tuned", world])]
        cells += [_metres(row.errors["tuned", HOME]), _metres(row.errors["tuned", world])]
        yield f"| {' | '.join([Path(row.case.race).stem, world, row.case.vehicle, *cells])} |"


def summary(rows: Sequence[Row]) -> Iterator[str]:
    """How far home is from abroad, with each vehicle as well described as is known, and whether tuning pays there."""
    best = {(row.case.race, row.case.world): row for row in sorted(rows, key=lambda row: row.case.description is not None)}.values()
    for label in ("tuned", "default"):
        near = [row for row in best if row.apart(label) <= NEAR]
        yield f"{label}: home and abroad at most {NEAR} points apart in {len(near)} of {len(best)} pairs of race and world"
        held = [row for row in best if row.passed[label, HOME].rate >= HOLDS]
        there = [row for row in held if row.passed[label, row.case.world].rate >= HOLDS]
        yield f"{label}: {len(there)} of {len(held)} that hold in {100 * HOLDS:.0f} % of the flights at home do so there"
    flown = [row for row in best if any(row.passed[label, row.case.world].successes for label in ("default", "tuned"))]
    beaten = [f"{row.case.race} in {row.case.world}" for row in flown if not row.tuned_is_better]
    better = len(flown) - len(beaten)
    yield f"tuned better than default in {better} of {len(flown)} pairs that either flies there; not: {', '.join(beaten) or '-'}"


def _percent(validation: Validation) -> str:
    low, high = validation.interval
    return f"{100 * validation.rate:.0f} [{100 * low:.0f}, {100 * high:.0f}]"


def _metres(errors: tuple[float, float]) -> str:
    return "-" if np.isnan(errors[0]) else f"{errors[0]:.2f}, {errors[1]:.2f}"


def _digest(*values: Any) -> str:
    return hashlib.sha256(repr(values).encode()).hexdigest()[:16]


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _cases(pairs: Sequence[tuple[str, str]], descriptions: Mapping[str, Description]) -> Iterator[Case]:
    """Each pair, and once more where the vehicle is described as the world has it."""
    for race, world in pairs:
        yield Case(race, world)
        description = descriptions.get(f"{world}/{Path(race).stem}", descriptions.get(world))
        if description is not None:
            yield Case(race, world, description)


def _pair(text: str) -> tuple[str, str]:
    race, _, world = text.partition("@")
    return race, world


def _description(text: str) -> tuple[str, Description]:
    where, _, file = text.partition("=")
    return where, partial(_with_keys, Path(file))


def _with_keys(file: Path, vehicle: Quadrotor) -> Quadrotor:
    """A vehicle with the keys of a file."""
    return check(Quadrotor, {**vehicle.model_dump(exclude_unset=True), **tomllib.loads(file.read_text(encoding="utf-8"))}, str(file))


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly what is missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", nargs="+", type=_pair, default=PAIRS, metavar="RACE@WORLD")
    parser.add_argument("--vehicle", action="append", type=_description, default=[], metavar="WORLD[/RACE]=FILE")
    parser.add_argument("--flights", type=int, default=50)
    parser.add_argument("--instances", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("build/home_and_abroad"))
    options = parser.parse_args(arguments)
    rows = []
    with Journal.opened(options.out, digest_code(Path(__file__))) as kept:
        study = Study(kept, options.flights, options.instances)
        for case in _cases(options.pairs, {**KNOWN, **dict(options.vehicle)}):
            try:
                rows.append(study.row(case))
            except InputError as error:  # a world that is not installed
                _say(f"{case.race} in {case.world} is left out: {error}")
    print("\n".join([*table(rows), "", *summary(rows)]))


if __name__ == "__main__":
    main()
