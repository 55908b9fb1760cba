"""A study survives kills, full disks and second processes, and refuses what it is not."""

from __future__ import annotations

import json
import os
import re
import signal
import sqlite3
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import reduce
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from fake_world import FakeWorld, make_scenario
from hotlap.core.errors import InputError, StudyError
from hotlap.core.seeds import Stream
from hotlap.race.race import JudgeSettings
from hotlap.reference.segmentation import SegmentClass, Segments
from hotlap.study.configuration import Configuration, first_difference, load_configuration, pack_reference, unpack_reference
from hotlap.study.database import FILE, Database, is_begun
from hotlap.study.formats import seal
from hotlap.study.increments import grow
from hotlap.study.study import Study, new_folder
from hotlap.study.versions import SIMULATORS
from hotlap.tuning.goal import parse_goal
from hotlap.tuning.loop import TuningSettings, tune
from hotlap.tuning.objective import Objective
from hotlap.tuning.scoring import Metric

HERE = Path(__file__).parents[1]


@pytest.fixture(autouse=True)
def _no_waiting_for_the_disk(monkeypatch) -> None:
    """A process that is killed leaves to the system what it has written; only a power cut would need the disk to have it."""
    begin = Database.__init__

    def connect(self, folder, *, owned):
        begin(self, folder, owned=owned)
        self.execute("PRAGMA synchronous = OFF")

    monkeypatch.setattr(Database, "__init__", connect)


def configure(tuner: str = "metropolis_hastings:tied", **settings) -> Configuration:
    scenario = make_scenario()
    asked = TuningSettings(**{"seed": 1, "budget": 60, "validation": 50, **settings})
    return Configuration(scenario, "fake", Metric.TIME, tuner, asked, scenario.space.first_guess(2))


def long(**settings) -> Configuration:
    """One that spends its whole budget."""
    return configure(goal=parse_goal("none"), **settings)


def run(folder: Path, configuration: Configuration, world: FakeWorld | None = None):
    with Study.open(folder, configuration) as study:
        return study.run(Objective(configuration.scenario, world or FakeWorld()))


def content(folder: Path) -> list:
    """All that a run decides: flights and the state of the run, as SQLite has them."""
    connection = sqlite3.connect(folder / FILE)
    flights = connection.execute("SELECT * FROM flight ORDER BY stream, number").fetchall()
    entries = connection.execute("SELECT * FROM entry WHERE key != 'wall_time' ORDER BY key").fetchall()
    changes = [json.loads(change) for (change,) in connection.execute("SELECT change FROM increment ORDER BY rowid")]
    connection.close()
    return [flights, entries, json.dumps(reduce(grow, changes, None))]


def wound(folder: Path, statement: str) -> None:
    """Change a study by hand, with checksums that fit."""
    connection = sqlite3.connect(folder / FILE)
    connection.execute(statement)
    with suppress(sqlite3.OperationalError):  # a table may be gone
        seal(lambda statement, values=(): connection.execute(statement, values).fetchall())
    connection.commit()
    connection.close()


def test_a_study_holds_every_flight_as_it_was_flown(tmp_path):
    result = run(tmp_path, configure())
    with Study.read(tmp_path) as study:
        ledger = study.flights()
        tuning = study.tuning
    batches = list(tune(Objective(make_scenario(), FakeWorld()), type(tuning)(tuning.tuner, make_scenario(), configure().settings)))
    validated = ledger.streams == Stream.VALIDATION
    order = np.argsort(np.concatenate([batch.ledger.streams for batch in batches]) == Stream.VALIDATION, kind="stable")
    for name in ("numbers", "seeds", "streams", "parameters", "cost", "failed_segment", "lap_time", "accepted"):
        np.testing.assert_array_equal(
            getattr(ledger, name), np.concatenate([getattr(batch.ledger, name) for batch in batches])[order], err_msg=name
        )
    assert result.flights == (~validated).sum() == batches[-1].flights
    assert result.validation_flights == validated.sum() == 50
    assert result.validation is not None
    assert result.validation.successes == (ledger.of(Stream.VALIDATION).completion == 1).sum()
    assert result.best.confirmed


def test_result_has_the_keys_that_are_relied_on(tmp_path):
    plain = run(tmp_path, configure()).dump()
    assert set(plain) >= {
        "race",
        "tuner",
        "seed",
        "flights",
        "search_flights",
        "completion",
        "confirmed",
        "validation",
        "lap_time",
        "cost",
        "wall_time",
    }
    assert set(plain["validation"]) == {"flights", "successes", "rate", "low", "high"}
    assert (plain["race"], plain["tuner"], plain["completion"], plain["confirmed"]) == ("straight", "metropolis_hastings:tied", 1.0, True)
    json.dumps(plain, allow_nan=False)


def test_a_finished_study_reports_its_result_again_without_flying(tmp_path):
    first = run(tmp_path, configure())
    world = FakeWorld()
    again = run(tmp_path, configure(), world)
    assert world.batches == []
    assert {**again.dump(), "wall_time": 0} == {**first.dump(), "wall_time": 0}
    np.testing.assert_array_equal(again.best.parameters, first.best.parameters)


PROGRAM = """
import sys
from pathlib import Path
from fake_world import FakeWorld
from hotlap.tuning.objective import Objective
from hotlap.study.study import Study
from study.test_study import long
configuration = long(budget=45, batch=3)
import dataclasses
configuration = dataclasses.replace(configuration, tuner=sys.argv[2])
with Study.open(Path(sys.argv[1]), configuration) as study:
    study.run(Objective(configuration.scenario, FakeWorld(pause=0.01)), lambda batch: print(batch.flights, flush=True))
"""


@pytest.mark.check
@pytest.mark.parametrize("tuner", ["metropolis_hastings:tied", "random_search:uniform"])
def test_killed_again_and_again_and_resumed_equals_never_stopped(tmp_path, tuner):
    configuration = replace(long(budget=45, batch=3), tuner=tuner)
    for lines in (1, 3, 2):
        process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, str(tmp_path / "killed"), tuner],
            cwd=HERE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert process.stdout is not None
        seen = [process.stdout.readline() for _ in range(lines)]
        process.send_signal(signal.SIGKILL)
        _, errors = process.communicate()
        assert all(line.strip().isdigit() for line in seen), errors
        assert process.returncode == -signal.SIGKILL
    with Study.read(tmp_path / "killed") as study:
        before = len(study.flights())
        openings = len(study.openings)
    assert 6 <= before < 45
    assert openings == 3
    run(tmp_path / "killed", configuration)
    run(tmp_path / "whole", configuration)
    assert content(tmp_path / "killed") == content(tmp_path / "whole")


def run_until_write(folder: Path, configuration: Configuration, last: int) -> bool:
    """Run a study in a process that dies at a write, the next after so many; whether it did."""
    child = os.fork()
    if child == 0:
        execute, writes = Database.execute, count()

        def counted(self, statement, values=()):
            if not statement.startswith(("PRAGMA q", "SELECT")) and next(writes) == last:
                os._exit(9)
            return execute(self, statement, values)

        Database.execute = counted
        try:
            run(folder, configuration)
        finally:
            os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9


@pytest.mark.check
def test_killed_between_any_two_writes_a_study_is_whole(tmp_path):
    """Every statement that writes may be the last one of the process: what is found then is a state between two batches."""
    configuration = long(budget=4, batch=2, validation=3)
    run(tmp_path / "whole", configuration)
    last = 0
    while run_until_write(tmp_path / str(last), configuration, last):
        run(tmp_path / str(last), configuration)
        assert content(tmp_path / str(last)) == content(tmp_path / "whole"), last
        last += 1
    assert last > 20


@pytest.mark.check
def test_a_second_process_is_refused_with_one_line_and_served_after_the_first(tmp_path):
    program = f"from study.test_study import run, configure\nrun({str(tmp_path)!r}, configure())"
    with Study.open(tmp_path, configure()):
        refused = subprocess.run([sys.executable, "-c", program], cwd=HERE, capture_output=True, text=True, check=False)
    assert re.search(r"StudyError: .*: process \d+ is working on this study; wait for it, or give another folder\n$", refused.stderr)
    assert subprocess.run([sys.executable, "-c", program], cwd=HERE, capture_output=True, check=False).returncode == 0


def test_a_study_can_be_read_while_another_process_works_on_it(tmp_path):
    configuration = long()
    with Study.open(tmp_path, configuration) as study:
        for batch in tune(Objective(configuration.scenario, FakeWorld()), study.tuning):
            study.record(batch)
            if batch.flights >= 10:
                break
        with Study.read(tmp_path) as reader:
            assert len(reader.flights()) == 10
            assert reader.result is not None
            assert reader.result.validation is None


def differing() -> dict[str, tuple[str, Configuration]]:
    base = configure()
    other_reference = replace(base.scenario.reference, position=base.scenario.reference.position + 1e-9)
    return {
        "seed": ("seed: this study has 1, asked for is 2", configure(seed=2)),
        "tuner": ("tuner.name: this study has .*tied", configure("metropolis_hastings:paper")),
        "goal": ('goal: this study has "completion=1", asked for is "none"', long()),
        "confirm": ("confirm: this study has 4", configure(confirm=3)),
        "world": ("world: ", replace(base, world="another")),
        "metric": ("metric: ", replace(base, metric=Metric.MEAN_ERROR)),
        "judge": (
            "race.judge.distance: this study has 1.3, asked for is 1.2",
            replace(base, scenario=make_scenario(JudgeSettings(distance=1.2))),
        ),
        "reference": ("reference: ", replace(base, scenario=replace(base.scenario, reference=other_reference))),
        "guess": ("first_guess: ", replace(base, first_guess=base.first_guess * 1.001)),
        "budget": ("budget: this study has 60 flights and may be given more, not 50", configure(budget=50)),
    }


@pytest.mark.parametrize("case", differing())
def test_another_configuration_is_refused_naming_the_difference_and_nothing_is_changed(tmp_path, case):
    with Study.open(tmp_path, configure()):
        pass
    before = content(tmp_path)
    message, other = differing()[case]
    with pytest.raises(StudyError, match=message) as refused:
        Study.open(tmp_path, other)
    assert "\n" not in str(refused.value)
    assert content(tmp_path) == before


@dataclass(frozen=True)
class Rounds:
    """Settings of a tuner of one's own, which happen to be called as a run's are."""

    budget: int = 10
    provenance: str = "a paper"


class Own:
    """A tuner of one's own, as far as a configuration needs one."""

    def __init__(self, name: str, settings: Rounds) -> None:
        self.name, self.settings = name, settings


class Remembering(Own):
    """Draws anywhere, and keeps all that it has been told in its state."""

    def start(self, first_guess, space, rng) -> None:
        self.guess, self.space, self.rng, self.points, self.costs = first_guess, space, rng, [], []

    def ask(self, n):
        asked = self.space.from_unit(self.rng.random((n, *self.guess.shape)))
        return asked if self.points else np.concatenate([self.guess[None], asked[1:]])

    def tell(self, parameters, scores):
        self.points += parameters.tolist()
        self.costs += scores.cost.tolist()
        return np.zeros(len(parameters), dtype=bool)

    def state(self):
        return {"points": self.points, "costs": self.costs, "rng": self.rng.bit_generator.state}  # its own memory, not a copy of it

    def restore(self, state):
        self.points, self.costs, self.rng.bit_generator.state = state["points"], state["costs"], state["rng"]


PRESETS = {"rounds": Rounds()}


@pytest.mark.parametrize("changed", [Rounds(budget=20), Rounds(provenance="another paper")])
def test_settings_of_a_tuner_count_whatever_they_are_called(tmp_path, monkeypatch, changed):
    asked = configure(f"{__name__}.Remembering")
    with Study.open(tmp_path, asked):
        before = asked.fingerprint
    monkeypatch.setitem(PRESETS, "rounds", changed)
    assert asked.fingerprint != before
    with pytest.raises(StudyError, match=r"tuner\.(budget|provenance): this study has "):
        Study.open(tmp_path, asked)


def test_a_first_guess_is_the_same_whatever_it_is_called(tmp_path):
    asked = [replace(configure(), first_guess_name=name) for name in ("my guesses/one.toml", "default")]
    assert asked[0].fingerprint == asked[1].fingerprint == configure().fingerprint
    for one in asked:
        with Study.open(tmp_path, one) as study:
            assert study.configuration.first_guess_name == "my guesses/one.toml", "the name that it began with"
    with Study.read(tmp_path) as study:
        assert study.configuration.first_guess_name == "my guesses/one.toml"


def far(flights, scores):  # noqa: ARG001
    return flights.max_error


def test_a_study_remembers_a_cost_of_ones_own(tmp_path):
    base = long(budget=20)
    own = Objective(base.scenario, FakeWorld(), cost=far)
    asked = replace(base, cost=own.own_cost)
    with Study.open(tmp_path, asked) as study:
        study.run(own)
        ledger = study.flights()
        np.testing.assert_array_equal(ledger.cost, ledger.max_error)
    with Study.read(tmp_path) as study:
        assert study.configuration.cost == own.own_cost
        assert study.configuration.fingerprint == asked.fingerprint != base.fingerprint
    with pytest.raises(StudyError, match=r"cost: this study has .*far [0-9a-f]{8}.*, asked for is \"\"; another study needs"):
        Study.open(tmp_path, base)


def test_costs_are_called_by_their_unit_or_by_the_name_of_ones_own():
    base = configure()
    assert [replace(base, metric=metric).cost_name for metric in Metric] == ["cost [s]", "cost [m]"]
    assert replace(base, cost=Objective(base.scenario, FakeWorld(), cost=far).own_cost).cost_name == "cost, far"


@pytest.mark.parametrize("change", [{"metric": Metric.MEAN_ERROR}, {"cost": far}, {"randomise": 0.1}, {"world": FakeWorld(name="another")}])
def test_a_study_is_not_flown_by_what_it_was_not_recorded_for(tmp_path, change):
    configuration = configure()
    with Study.open(tmp_path, configuration) as study:
        with pytest.raises(StudyError, match=f"{next(iter(change))}: this study has "):
            study.run(replace(Objective(configuration.scenario, FakeWorld()), **change))
        assert len(study.flights()) == 0


def test_fingerprints_tell_studies_apart_and_budgets_not():
    prints = {case: other.fingerprint for case, (_, other) in differing().items()}
    assert prints.pop("budget") == configure().fingerprint
    assert len({*prints.values(), configure().fingerprint}) == len(prints) + 1


def test_where_numbers_come_from_may_be_reworded(tmp_path):
    base = configure()
    with Study.open(tmp_path, base):
        pass
    scenario = replace(base.scenario, race=base.scenario.race.model_copy(update={"provenance": "reworded"}))
    with Study.open(tmp_path, replace(base, scenario=scenario)) as study:
        assert study.result is None


def test_keys_that_a_study_of_an_earlier_version_does_not_have_get_their_defaults():
    now = long().dump()
    before = json.loads(json.dumps(now))
    before["race"]["track"].pop("laps")
    before["race"]["vehicle"].pop("radius")
    for name in ("lag_lead", "offset_free", "reference_drag"):
        before["race"]["controller"].pop(name)
    assert first_difference(before, now) == ("race.controller.lag_lead", 0.0, 0.5)  # how it was flown then
    now["race"]["controller"] |= {"lag_lead": 0.0, "offset_free": False, "reference_drag": False}
    assert first_difference(before, now) is None
    before["race"]["track"]["laps"] = 2
    assert first_difference(before, now) == ("race.track.laps", 2, 1)


def test_a_larger_budget_goes_on_and_equals_one_run_of_that_budget(tmp_path):
    run(tmp_path / "raised", long(budget=20))
    result = run(tmp_path / "raised", long(budget=45))
    run(tmp_path / "whole", long(budget=45))
    assert result.flights == 45
    assert content(tmp_path / "raised") == content(tmp_path / "whole")
    with Study.read(tmp_path / "raised") as study:
        assert study.configuration.settings.budget == 45


@pytest.mark.check
def test_what_is_written_grows_with_the_flights_and_not_with_their_square(tmp_path, monkeypatch):
    """3000 search flights, resumed after each third: a third writes what another does."""
    execute, insert, written = Database.execute, Database.insert, []

    def count(values) -> tuple:
        values = tuple(values)
        written[-1] += sum(len(value) if isinstance(value, str | bytes) else 8 for value in values)
        return values

    monkeypatch.setattr(Database, "execute", lambda self, statement, values=(): execute(self, statement, count(values)))
    monkeypatch.setattr(Database, "insert", lambda self, statement, rows: insert(self, statement, [count(row) for row in rows]))
    for budget in (1000, 2000, 3000):
        written.append(0)
        run(tmp_path / "resumed", replace(long(budget=budget, batch=50, validation=0), tuner=f"{__name__}.Remembering"))
    assert max(written) < 1.1 * min(written)
    run(tmp_path / "whole", replace(long(budget=3000, batch=50, validation=0), tuner=f"{__name__}.Remembering"))
    assert content(tmp_path / "resumed") == content(tmp_path / "whole")
    with Study.read(tmp_path / "whole") as study:
        assert len(study.tuning.tuner.state()["costs"]) == 3000


def test_a_full_disk_is_one_line_and_loses_nothing_finished(tmp_path):
    configuration = long(budget=120)
    with Study.open(tmp_path / "full", configuration) as study:
        database = study._database
        pages = database.execute("PRAGMA page_count")[0][0]
        database.execute(f"PRAGMA max_page_count = {pages + 2}")
        with pytest.raises(StudyError, match="the disk is full; all batches so far are kept") as refused:
            study.run(Objective(configuration.scenario, FakeWorld()))
        assert "\n" not in str(refused.value)
        kept = len(study.flights())
    assert 10 < kept < 120
    world = FakeWorld()
    run(tmp_path / "full", configuration, world)
    run(tmp_path / "whole", configuration)
    assert sum(world.batches) == 120 - kept + 50
    assert content(tmp_path / "full") == content(tmp_path / "whole")


def test_a_file_that_cannot_grow_is_one_line_too(tmp_path):
    program = f"""
import resource, signal
from study.test_study import run, long
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))
run({str(tmp_path)!r}, long(budget=300))
"""
    refused = subprocess.run([sys.executable, "-c", program], cwd=HERE, capture_output=True, text=True, check=False)
    assert re.search(r"StorageError: .*all batches so far are kept.*\n$", refused.stderr), refused.stderr
    with Study.read(tmp_path) as study:
        assert 10 < len(study.flights()) < 300


@pytest.mark.parametrize("opener", [lambda folder: Study.open(folder, configure()), Study.read], ids=["open", "read"])
@pytest.mark.parametrize(
    ("harm", "message"),
    [
        (lambda folder: (folder / FILE).write_text("not a database, not at all " * 100), "is no database, so no study"),
        (lambda folder: wound(folder, "PRAGMA user_version = 99"), "was made by a newer hotlap .format 99"),
        (lambda folder: wound(folder, "PRAGMA user_version = 0"), "is damaged: there is no format 0"),
        (lambda folder: wound(folder, "PRAGMA application_id = 7"), "is a database, but no study"),
        (lambda folder: wound(folder, "DELETE FROM entry"), "damaged"),
        (lambda folder: (folder / FILE).write_bytes((folder / FILE).read_bytes()[:9000] + b"\7" * 6000), "damaged"),
        (lambda folder: wound(folder, "DROP TABLE entry"), "damaged: its table entry is not as it was made"),
    ],
)
def test_what_is_no_study_is_refused_with_one_line(tmp_path, opener, harm, message):
    with Study.open(tmp_path, configure()):
        pass
    harm(tmp_path)
    with pytest.raises(StudyError, match=message) as refused:
        opener(tmp_path)
    assert str(refused.value).startswith(str(tmp_path))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "harm",
    [
        "UPDATE flight SET parameters = zeroblob(16 * :size) WHERE number = 3",
        "UPDATE flight SET parameters = zeroblob(8 * :size * number) WHERE number IN (0, 2)",  # as many as before
        "UPDATE flight SET parameters = zeroblob(0)",
        "UPDATE flight SET parameters = 1.5 WHERE number = 3",
    ],
)
def test_a_flight_whose_parameters_are_of_another_shape_is_damage(tmp_path, harm):
    run(tmp_path, configure())
    with Study.read(tmp_path) as study:
        assert len(study.records()) > 3
        size = study.values.size
    wound(tmp_path, harm.replace(":size", str(size)))
    with Study.read(tmp_path) as study, pytest.raises(StudyError, match="is damaged: its flights cannot be read back"):
        study.records()


def test_a_race_that_this_version_refuses_cannot_be_read(tmp_path):
    """Angles of gates were not looked at by earlier versions."""
    with Study.open(tmp_path, configure()):
        pass
    wound(tmp_path, "UPDATE entry SET value = json_set(value, '$.race.track.gates[0].yaw', 90.0) WHERE key = 'configuration'")
    with pytest.raises(StudyError, match=r"race\.track\.gates\[0\]\.yaw: 90 rad is more than a full turn.*another version") as refused:
        Study.read(tmp_path)
    assert "\n" not in str(refused.value)


def test_a_folder_without_a_study_cannot_be_read(tmp_path):
    for folder in (tmp_path, tmp_path / "missing"):
        with pytest.raises(StudyError, match="holds no study"):
            Study.read(folder)
    (tmp_path / FILE).touch()
    with pytest.raises(StudyError, match="is empty"):
        Study.read(tmp_path)


def test_a_study_is_begun_when_something_is_in_it(tmp_path):
    assert not is_begun(tmp_path)
    (tmp_path / FILE).touch()
    assert not is_begun(tmp_path)
    Study.open(tmp_path, configure()).close()
    assert is_begun(tmp_path)
    (tmp_path / FILE).write_text("a shopping list")
    with pytest.raises(StudyError, match="no database"):
        is_begun(tmp_path)


def test_a_path_that_cannot_be_a_folder_is_refused(tmp_path):
    (tmp_path / "file").touch()
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(StudyError, match="cannot be used as the folder of a study"):
            Study.open(folder, configure())


def test_new_folders_are_new_and_bear_the_races_name(tmp_path):
    folders = [new_folder(race, tmp_path / "runs") for race in ("circle-34", "circle-34", "../my race!", "...")]
    assert len(set(folders)) == 4
    assert all(folder.is_dir() and folder.parent == tmp_path / "runs" for folder in folders)
    assert re.fullmatch(r"circle-34-\d{8}-\d{6}", folders[0].name)
    assert folders[2].name.startswith("my-race-")
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot be made"):
        new_folder("circle-34", tmp_path / "file")


def test_versions_and_configuration_come_back_as_recorded(tmp_path):
    asked = configure(goal=parse_goal("mean_error<0.25"), confirm=2)
    with Study.open(tmp_path, asked):
        pass
    with Study.read(tmp_path) as study:
        assert study.configuration.fingerprint == asked.fingerprint
        assert study.configuration.settings == asked.settings
        assert study.configuration.scenario.race == asked.scenario.race
        ((_, versions),) = study.openings
        assert len(study.flights()) == 0
    assert set(versions) - set(SIMULATORS) == {"hotlap", "code", "numpy", "numba", "casadi", "python", "platform"}


def test_a_reference_packs_bit_for_bit():
    reference = make_scenario().reference
    unpacked = unpack_reference(pack_reference(reference))
    for name, values in vars(reference).items():
        np.testing.assert_array_equal(getattr(unpacked, name), values)
    asked = configure()
    assert load_configuration(json.loads(json.dumps(asked.dump())), unpacked).dump() == asked.dump()


def test_shared_segments_come_back_and_change_the_fingerprint():
    asked = configure()
    starts, kinds = np.array([0.0, 2.5, 4.0]), (SegmentClass.ASCENT, SegmentClass.FLAT, SegmentClass.ASCENT)
    segments = Segments(starts, kinds, asked.scenario.segments.duration, owners=(0, 1, 0))
    shared = replace(asked, scenario=replace(asked.scenario, segments=segments))
    back = load_configuration(json.loads(json.dumps(shared.dump())), asked.scenario.reference)
    assert back.scenario.segments.owners == (0, 1, 0)
    assert len(back.scenario.segments) == len(back.first_guess) == 2
    others = [asked, back, *(replace(back, scenario=replace(back.scenario, segments=replace(segments, owners=o))) for o in [(), (0, 1, 1)])]
    assert len({other.fingerprint for other in others}) == 4
    assert back.fingerprint == shared.fingerprint
