"""`hotlap learn`, with real flights: what is learnt is the same however it came about."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.analysis import learning
from hotlap.analysis.learning import SPEEDS, Lesson, fly_lesson, lessons
from hotlap.cli import main
from hotlap.files.descriptions import Kind, load_race, load_track, names
from hotlap.first_guess.guess import first_guess
from hotlap.first_guess.training_set import load_training_set
from hotlap.planning.preparation import prepare

RACES = ("circle-20", "airsim-circle-20")  # the default weights fly both


@pytest.fixture(autouse=True)
def _quick(monkeypatch):
    monkeypatch.setattr(learning, "VALIDATION", 8)
    monkeypatch.setattr(learning, "SEEDS", 2)


def learn(folder, *races: str) -> bytes:
    assert main(["learn", *races, "--jobs", "1", "--out", str(folder)]) == 0
    return (folder / "first_guess.json").read_bytes()


def test_it_learns_what_flies(tmp_path, capsys):
    learn(tmp_path, *RACES)
    training = load_training_set(tmp_path / "first_guess.json")
    assert [(race.track, race.vehicle) for race in training.races] == [("circle", "hummingbird"), ("circle", "airsim")]
    assert training.passed.max(axis=1).tolist() == [1.0, 1.0]
    assert training.candidates[0] == load_race("circle-20").controller.default
    assert f"begin with it: hotlap tune RACE --first-guess {tmp_path}" in capsys.readouterr().out
    scenario = prepare("circle-20")
    assert tuple(first_guess(scenario, "learned", training)[0].tolist()) in training.candidates


@pytest.mark.check
def test_what_was_interrupted_ends_as_if_it_had_not_been(tmp_path, capsys):
    whole = learn(tmp_path / "whole", *RACES)
    lines = (tmp_path / "whole" / "lines.jsonl").read_bytes().splitlines(keepends=True)
    for kept in range(len(lines)):
        folder = tmp_path / f"{kept} lines"
        folder.mkdir()
        (folder / "lines.jsonl").write_bytes(b"".join(lines[:kept]) + lines[kept][:40])
        assert learn(folder, *RACES) == whole
    capsys.readouterr()
    assert learn(tmp_path / "whole", *RACES) == whole
    assert "now" not in capsys.readouterr().err


def test_a_race_that_is_given_twice_is_learnt_from_once(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text('base = "circle-20"\nname = "mine"\n', encoding="utf-8")
    learn(tmp_path / "l", "mine.toml", "./mine.toml")
    assert len(load_training_set(tmp_path / "l" / "first_guess.json").races) == 1


def test_parameters_are_flown_with_the_same_noise():
    default, other = load_race("circle-34").controller.default, (20.0, 200.0, 20.0, 6.0, 5.0)
    ((passed, completed),) = fly_lesson((Lesson(load_race("circle-34"), "me"), [default, other, default]))
    assert passed[0] == passed[2] != passed[1]
    assert completed[0] == completed[2]


@pytest.fixture(scope="module")
def shipped() -> tuple[Lesson, ...]:
    """The lessons that come with hotlap, made once."""
    return lessons()


def test_nothing_is_learnt_from_what_claims_are_made_about(shipped):
    tracks = {lesson.race.track.name: lesson.race.track for lesson in shipped}
    built_in = {name: load_track(name) for name in names(Kind.TRACK) if not name.startswith("soccer-medium")}
    assert not set(tracks) & set(built_in)
    shapes = {track.gate_positions.tobytes() for track in tracks.values()}
    assert not shapes & {track.gate_positions.tobytes() for track in built_in.values()}


def test_every_vehicle_flies_every_layout_at_every_speed_and_soccer_medium(shipped):
    for vehicle, speeds in SPEEDS.items():
        own = [lesson.race for lesson in shipped if lesson.vehicle == vehicle]
        layouts = [race.track.name.partition("-")[0] for race in own]
        assert {layouts.count(layout) for layout in ("flat", "climb", "drop", "loop", "spiral")} == {len(speeds)}
        assert {race.planning.v_max for race in own} == {*speeds, 20.0}
        assert layouts.count("soccer") == 1


def test_lessons_differ_in_who_flies(shipped):
    scenarios = {lesson.vehicle: lesson.race for lesson in shipped}
    assert len({race.vehicle.fingerprint + race.control_model.fingerprint for race in scenarios.values()}) == len(SPEEDS)
    assert scenarios["hummingbird"].control_model.delay == scenarios["hummingbird"].vehicle.delay > 0
    assert scenarios["racer, late"].control_model.delay < scenarios["racer, late"].vehicle.delay
    assert np.isclose(scenarios["racer"].controller.thrust[1], 32.0)
