"""`hotlap.transfer`: the same parameters in several worlds, with the same noise, each flight flown once."""

from __future__ import annotations

import json
import re
import shutil
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hotlap
from docs.test_json import documented, keys_of
from flight.scenarios import make_scenario
from hotlap import worlds
from hotlap.api.progress import Quiet
from hotlap.cli import main
from hotlap.core.errors import InputError, StudyError, UnknownNameError
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.study.snapshot import read_snapshot
from hotlap.study.study import Study
from hotlap.worlds.plant_simulator import PlantSimulator
from hotlap.worlds.simulator import SimulatorError
from hotlap.worlds.stepped import Stepped
from plausible_world import PlausibleWorld
from studies import begin, carry, configure

NOISE = {"thrust": 0.02, "rates": 0.1, "thrust_bias": 0.01, "position": 0.05, "velocity": 0.05, "attitude": 0.01}
SCENARIO = make_scenario(noise=NOISE)


class Home(PlausibleWorld):
    """Tunes in no time what the built-in world then flies."""

    name = "built-in"


class Counted(Stepped):
    """The built-in world's plant as a simulator, which counts its flights.

    Args:
        name: of the world.
        lose: flights that are lost, counted from 1.
    """

    def __init__(self, name: str = "plant", lose: tuple[int, ...] = ()) -> None:
        super().__init__(name, self._build)
        self.flown, self._lose, self.note = 0, lose, lambda _: None

    def _build(self, scenario, _):
        world, lose = self, self._lose

        class Simulator(PlantSimulator):
            def reset(self, lane, start):
                world.flown += 1
                super().reset(lane, start)

            def advance(self, commands, duration):
                super().advance(commands, duration)
                if world.flown in lose:
                    raise SimulatorError("the line is cut")

        return Simulator(scenario.race.vehicle, scenario.race.control_model)


class Absent(Stepped):
    """A world that is not installed."""

    def __init__(self) -> None:
        super().__init__("moon", self._fail)

    @staticmethod
    def _fail(*_):
        raise SimulatorError("moon is not installed: pip install moon")


class Stop(BaseException):
    pass


class Stopping(Quiet):
    """Stops the work after some flights."""

    def __init__(self, after: int) -> None:
        self._after = after

    @contextmanager
    def pieces(self, *_, even=True):
        assert not even

        def count(_):
            self._after -= 1
            if not self._after:
                raise Stop

        yield count


@pytest.fixture(scope="module")
def finished(tmp_path_factory) -> Path:
    """A study that has ended."""
    folder, asked = tmp_path_factory.mktemp("finished"), configure(SCENARIO, goal="mean_error<0.01", budget=30, validation=0)
    carry(folder, replace(asked, world="built-in"), Home())
    return folder


@pytest.fixture
def study(finished, tmp_path) -> Path:
    return Path(shutil.copytree(finished, tmp_path / "study"))


@pytest.mark.check
def test_every_world_flies_the_same_parameters_with_the_same_noise_home_first(study):
    found = hotlap.transfer(study, to=Counted(), flights=4, seed=2)
    assert found.worlds == ("built-in", "plant")
    assert [(row.world, row.label) for row in found.by_world] == [(w, p) for w in found.worlds for p in ("default", "tuned")]
    seeds = flight_seeds(2, Stream.DEMONSTRATION, 0, 4).tolist()
    assert [[flight.seed for flight in row.flights] for row in found.by_world] == [seeds] * 4
    home, abroad = found.flights[:8], found.flights[8:]
    np.testing.assert_allclose([f.mean_error for f in home], [f.mean_error for f in abroad], atol=0.02)  # the same physics
    assert len({flight.mean_error for flight in abroad}) == 8


def test_errors_are_those_of_the_steps_that_were_flown(study):
    for flight in hotlap.transfer(study, to=Counted()).flights:
        assert len(flight.times) == len(flight.errors) > 100
        assert flight.errors[1:].mean() == pytest.approx(flight.mean_error, abs=1e-3)  # kept to a tenth of a millimetre
        assert flight.errors[1:].max() == pytest.approx(flight.max_error, abs=1e-3)


@pytest.mark.check
def test_an_interrupted_transfer_goes_on_and_flies_nothing_twice(study, tmp_path):
    whole = hotlap.transfer(shutil.copytree(study, tmp_path / "other"), to=Counted())
    first, second = Counted(), Counted()
    with pytest.raises(Stop) as stopped:
        hotlap.transfer(study, to=first, progress=Stopping(after=5))
    assert "nothing is lost; go on with: " in stopped.value.__notes__[0]
    again = hotlap.transfer(study, to=second)
    assert 0 < first.flown < 6
    assert first.flown + second.flown == 6
    assert [flight.dump() for flight in again.flights] == [flight.dump() for flight in whole.flights]


def test_what_is_there_needs_no_simulator_and_more_flights_fly_what_is_missing(study):
    before = hotlap.transfer(study, to=Counted("moon"))
    again = hotlap.transfer(study, to=Absent())
    assert again.rows() == before.rows()
    more = Counted("moon")
    assert len(hotlap.transfer(study, to=more, flights=5).flights) == 20
    assert more.flown == 4


@pytest.mark.check
def test_other_parameters_are_flown_for_themselves(study):
    hotlap.transfer(study, to=Counted())
    asked, other = configure(SCENARIO, goal="mean_error<0.01", budget=30, validation=0, seed=8), Counted()
    for file in study.glob("study.*"):
        file.unlink()
    carry(study, replace(asked, world="built-in"), Home())
    hotlap.transfer(study, to=other)
    assert other.flown == 3, "the default parameters are what they were"


@pytest.mark.check
def test_a_flight_that_is_lost_is_flown_again(study, tmp_path):
    whole = hotlap.transfer(shutil.copytree(study, tmp_path / "other"), to=Counted())
    cut = Counted(lose=(2, 5))
    assert hotlap.transfer(study, to=cut).rows() == whole.rows()
    assert cut.flown == 8


def test_a_world_that_is_lost_time_and_again_ends_it_and_says_so(study):
    with pytest.raises(InputError, match=r"^to: plant was lost 3 times in a row: the line is cut"):
        hotlap.transfer(study, to=Counted(lose=tuple(range(2, 20))))
    kept = (study / "transfer" / "lines.jsonl").read_text().splitlines()
    assert len(kept) == 3


@pytest.mark.parametrize(
    ("to", "error", "message"),
    [
        ("mars", UnknownNameError, r"^to: there is no world named 'mars'"),
        ("built-in", InputError, r"^to: must name another world than built-in, where the study was tuned$"),
        (Absent(), InputError, r"^to: moon is not installed: pip install moon$"),
        ([Counted(), Absent()], InputError, r"^to: moon is not installed: pip install moon$"),
    ],
)
def test_a_world_that_cannot_be_flown_in_is_refused_before_anything_is_flown(study, to, error, message):
    with pytest.raises(error, match=message):
        hotlap.transfer(study, to=to)
    assert not (study / "transfer").exists()


def test_what_else_is_refused(study, tmp_path):
    with pytest.raises(InputError, match=r"^flights: must be from 3 to 1000, not 2$"):
        hotlap.transfer(study, to=Counted(), flights=2)
    with pytest.raises(StudyError, match="holds no study"):
        hotlap.transfer(tmp_path, to=Counted())
    begin(tmp_path / "young", configure(SCENARIO))
    with pytest.raises(StudyError, match=r"holds a study that has not ended; hotlap\.tune\(RACE, out='\S*young'\) goes on with it"):
        hotlap.transfer(tmp_path / "young", to=Counted())


def test_the_page_has_the_table_and_both_figures(study):
    found = hotlap.transfer(study, to=[Counted(), Counted("other")])
    page = found.page.read_text(encoding="utf-8")
    assert page.count('src="data:image/png;base64,') == len(found.pictures) == 2
    text = (found.folder / "page.md").read_text(encoding="utf-8")
    assert [found.folder / name for name in re.findall(r"!\[[^]]+\]\(([^)]+)\)", text)] == list(found.pictures)
    assert [path.name for path in found.pictures] == ["error_boxes.png", "error_over_time.png"]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in found.pictures)
    assert all(f"| {world} | {label} |" in text for world in ("built-in", "plant", "other") for label in ("tuned", "default"))
    with Study.read(study) as now:
        assert read_snapshot(now).remark.endswith("Flown in other worlds, too: transfer/page.html")


def test_a_result_is_shown_in_notebooks(study):
    found = hotlap.transfer(study, to=Counted())
    assert repr(found).startswith("<TransferResult circle-34: tuned in built-in, flown in plant: built-in 3 of 3 flights complete")
    assert len(found.rows()) == 12
    assert found.plot().get_axes()


@pytest.mark.check
def test_the_command_prints_the_same(study, monkeypatch, capsys):
    monkeypatch.setattr(worlds, "build", lambda name, *_: Counted() if name == "plant" else worlds.BuiltIn())
    assert main(["transfer", str(study), "--to", "plant"]) == 0
    told = capsys.readouterr()
    assert re.search(r"plant +tuned +3 of 3 +0\.\d+ / 0\.\d+ / 0\.\d+ ", told.out)
    assert "plant: tuned against default, mean error" in told.out
    assert "12 of 12 flights, now plant: tuned, " in told.err
    command = f"hotlap transfer {study} --to plant"
    assert f"`{command}`" in (study / "transfer" / "page.md").read_text(encoding="utf-8")
    assert main([*command.split()[1:], "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert documented()["transfer"] <= keys_of(document)
    assert [row["flights"] for row in document["rows"]] == [3] * 4


def test_another_version_than_the_study_was_tuned_with_is_one_line(study, monkeypatch, capsys):
    monkeypatch.setattr(worlds, "build", lambda name, *_: Counted() if name == "plant" else worlds.BuiltIn())
    monkeypatch.setattr("hotlap.study.versions.versions_now", lambda: {"hotlap": "99.0"})
    assert main(["transfer", str(study), "--to", "plant"]) == 0
    (line,) = [line for line in capsys.readouterr().err.splitlines() if "when the study was tuned" in line]
    assert line.startswith("note: hotlap is 99.0, and was ")


def test_a_command_that_asks_for_a_world_that_is_not_there_is_one_line(study, capsys):
    assert main(["transfer", str(study), "--to", "mars"]) == 2
    told = capsys.readouterr()
    assert told.err.startswith("hotlap: --to: there is no world named 'mars'")
    assert told.err.count("\n") == 1
