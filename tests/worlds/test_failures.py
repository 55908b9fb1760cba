"""Simulators that are killed, fall silent or answer nonsense cost the flight that was under way, and nothing else."""

from __future__ import annotations

import re
import threading
from dataclasses import fields

import numpy as np
import pytest

from flight.scenarios import make_scenario, parameters
from hotlap.core.errors import InputError
from hotlap.core.records import Cause, End, Flights
from hotlap.race.endings import in_words
from hotlap.study.configuration import Configuration
from hotlap.study.study import Study
from hotlap.tuning.goal import parse_goal
from hotlap.tuning.loop import TuningSettings
from hotlap.tuning.objective import Objective
from hotlap.tuning.scoring import Metric
from hotlap.worlds.plant_simulator import PlantSimulator
from hotlap.worlds.simulator import SimulatorError
from hotlap.worlds.stepped import Stepped
from worlds.process_simulator import SHORT, ProcessSimulator

NOISE = {"rates": 0.1, "position": 0.05}
SCENARIO = make_scenario(noise=NOISE)
SEEDS = np.arange(4)
PERIODS = 341  # answers of a flight that finishes: 340 control periods, and one to the reset


class Opener:
    """Opens simulators that behave as is told of the first, the second and so on; the rest behave well."""

    def __init__(self, *manners: tuple[str, ...]) -> None:
        self.manners, self.opened = list(manners), []

    def __call__(self, *_: object) -> ProcessSimulator:
        manner = self.manners[len(self.opened)] if len(self.opened) < len(self.manners) else ()
        self.opened.append(ProcessSimulator(*manner))
        return self.opened[-1]


@pytest.fixture(scope="module")
def undisturbed() -> Flights:
    opener = Opener()
    world = Stepped("process", opener)
    flights = world.fly(SCENARIO, parameters(4), SEEDS)
    world.close()
    assert opener.opened[0].process.returncode is not None
    return flights


def others_are_the_same(flights: Flights, undisturbed: Flights, lost: int) -> None:
    rows = np.delete(np.arange(4), lost)
    for field in fields(Flights):
        if field.name not in {"rooms", "gate_positions", "gate_times", "gate_segments", "logs"}:
            np.testing.assert_array_equal(getattr(flights, field.name)[rows], getattr(undisturbed, field.name)[rows], err_msg=field.name)


def test_a_program_of_ones_own_flies_the_race(undisturbed):
    assert undisturbed.end.tolist() == [End.FINISHED] * 4
    assert (undisturbed.max_error < 0.5).all()


@pytest.mark.check
@pytest.mark.parametrize(
    ("manner", "said"),
    [
        ("dies", "the simulator has ended"),
        ("hangs", f"the simulator has not answered for {SHORT:g} s"),
        ("babbles", "the simulator answers what nobody understands: b'garbage"),
        ("shortens", r"states of shape \(1, 7\) and rotor thrusts of shape \(1, 4\) are none of 1 drones"),
        ("bends", "an attitude with a quaternion of length 0 is none"),
    ],
)
def test_the_flight_that_was_under_way_is_lost_and_no_other(manner, said, undisturbed):
    opener, notes = Opener((manner, str(PERIODS + 151))), []
    world = Stepped("process", opener)
    world.note = notes.append
    flights = world.fly(SCENARIO, parameters(4), SEEDS)
    world.close()
    assert flights.end.tolist() == [End.FINISHED, End.CRASHED, End.FINISHED, End.FINISHED]
    assert flights.cause.tolist() == [Cause.NONE, Cause.LOST, Cause.NONE, Cause.NONE]
    assert flights.end_time[1] == pytest.approx(1.5)
    assert flights.gates_passed[1] == 1
    assert in_words(SCENARIO.race, End.CRASHED, 1, Cause.LOST) == "was lost before gate 2: the simulator failed"
    others_are_the_same(flights, undisturbed, 1)
    (note,) = notes
    assert re.search(said, note)
    assert note.startswith("process: ")
    assert note.endswith("; 1 flight lost, the next one opens it anew")
    assert "\n" not in note
    assert len(opener.opened) == 2
    assert all(one.process.returncode is not None for one in opener.opened)


def test_a_program_that_is_killed_from_outside_is_opened_anew(undisturbed):
    opener = Opener()
    world = Stepped("process", opener)
    world.note = lambda _: None
    world.watch = lambda ended: opener.opened[0].process.kill() if ended == 1 else None
    flights = world.fly(SCENARIO, parameters(4), SEEDS)
    world.close()
    others_are_the_same(flights, undisturbed, 1)
    assert set(flights.cause[1:2].tolist()) <= {Cause.NONE, Cause.LOST}
    assert len(opener.opened) == 2


def test_a_flight_that_had_not_begun_is_flown_by_the_next_simulator(undisturbed):
    world = Stepped("process", Opener(("dies", str(PERIODS))))
    world.note = lambda _: None
    flights = world.fly(SCENARIO, parameters(4), SEEDS)
    world.close()
    np.testing.assert_array_equal(flights.mean_error, undisturbed.mean_error)


def test_flights_in_all_lanes_of_a_simulator_are_lost_with_it():
    class Breaking(PlantSimulator):
        left = 200

        def advance(self, commands, duration):
            self.left -= 1
            if not self.left:
                raise ConnectionResetError(104, "connection reset by peer")
            super().advance(commands, duration)

    opened, notes = [], []

    def open_one(scenario, _):
        kind = PlantSimulator if opened else Breaking
        opened.append(kind(scenario.race.vehicle, lanes=3))
        return opened[-1]

    world = Stepped("breaking", open_one)
    world.note = notes.append
    flights = world.fly(SCENARIO, parameters(4), SEEDS)
    assert flights.cause.tolist() == [Cause.LOST] * 3 + [Cause.NONE]
    assert notes == ["breaking: [Errno 104] connection reset by peer; 3 flights lost, the next one opens it anew"]


@pytest.mark.parametrize("instances", [1, 2])
def test_a_simulator_that_is_lost_time_and_again_is_given_up(instances):
    opener = Opener(*[("dies", "100")] * 9)
    world = Stepped("process", opener, instances)
    world.note = lambda _: None
    before = set(threading.enumerate())  # of other tests, too
    with pytest.raises(InputError, match="on: process was lost 3 times in a row: the simulator has ended"):
        world.fly(SCENARIO, parameters(12), np.arange(12))
    assert all(one.process.returncode is not None for one in opener.opened)
    assert set(threading.enumerate()) <= before


def test_a_simulator_that_cannot_be_opened_leaves_a_study_intact(tmp_path):
    class Opens:
        times = 0

        def __call__(self, scenario, _):
            self.times += 1
            if self.times == 2:
                raise SimulatorError("moonsim is not installed: pip install moonsim")
            simulator = ProcessSimulator("dies", "1500") if self.times == 1 else PlantSimulator(scenario.race.vehicle)
            self.opened = simulator
            return simulator

    opens = Opens()
    world, guess = Stepped("moon", opens), parameters(1)[0]
    world.note = lambda _: None
    settings = TuningSettings(goal=parse_goal("none"), budget=12, validation=0, batch=2)
    configuration = Configuration(SCENARIO, "moon", Metric.TIME, "random_search", settings, guess)
    objective = Objective(SCENARIO, world)
    with Study.open(tmp_path, configuration) as study, pytest.raises(InputError, match="on: moonsim is not installed"):
        study.run(objective)
    with Study.open(tmp_path, configuration) as study:
        before = len(study.flights())
        assert before in {2, 4, 6, 8, 10}
        result = study.run(objective)
        assert result.flights == 12
        assert len(study.flights()) == 12
    world.close()


def test_a_study_refuses_another_world(tmp_path):
    settings, guess = TuningSettings(goal=parse_goal("none"), budget=2, validation=0), parameters(1)[0]
    names = ("betaflight:a.txt", "betaflight:b.txt")
    first, second = (Configuration(SCENARIO, name, Metric.TIME, "random_search", settings, guess) for name in names)
    Study.open(tmp_path, first).close()
    with pytest.raises(InputError, match=r'world: this study has "betaflight:a\.txt", asked for is "betaflight:b\.txt"'):
        Study.open(tmp_path, second)
