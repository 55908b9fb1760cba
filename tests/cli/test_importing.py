"""`hotlap import`."""

from __future__ import annotations

from pathlib import Path

import pytest

from hotlap.files.descriptions import load, load_quadrotor
from hotlap.race.race import Race
from worlds.airsim_plant import Plant
from worlds.airsim_server import Server

SAMPLES = Path(__file__).parents[1] / "importers" / "samples"
DRONE = str(SAMPLES / "rpg_quadrotor.yaml")


def test_it_writes_a_file_and_says_what_stands_at_its_top(hotlap, here):
    ran = hotlap("import", DRONE, "--name", "kite")
    assert (ran.code, ran.err) == (0, "")
    assert load(here / "kite.toml").name == "kite"
    first, *others = ran.out.splitlines()
    assert first == "wrote kite.toml: a quadrotor, from a quadrotor of rpg_time_optimal (YAML)"
    assert others[-1] == "next: hotlap check kite.toml"
    comments = " ".join(line[1:].strip() for line in (here / "kite.toml").read_text().splitlines() if line.startswith("#"))
    remarks = [line.strip() for line in others[:-1] if line.startswith("  ")]
    assert len(remarks) > 3
    assert all(remark in comments for remark in remarks)


def test_programs_are_told_the_same(hotlap, here):
    ran = hotlap("import", str(SAMPLES / "togt_track.yaml"), "--out", "mine.toml", "--json")
    assert {key: ran.document[key] for key in ("kind", "name", "file")} == {"kind": "track", "name": "togt_track", "file": "mine.toml"}
    assert ran.document["format"] == "a track of TOGT-Planner (YAML)"
    assert ran.document["taken"]
    assert ran.document["lost"]
    assert (here / "mine.toml").is_file()


def test_what_is_imported_can_be_checked_and_raced(hotlap, here):
    hotlap("import", DRONE, "--out", "kite.toml")
    hotlap("import", str(SAMPLES / "togt_track.yaml"), "--out", "garden.toml")
    assert hotlap("check", "garden.toml").code == 0
    (here / "sunday.toml").write_text('track = "garden.toml"\nvehicle = "kite.toml"\n', encoding="utf-8")
    race = load(here / "sunday.toml")
    assert isinstance(race, Race)
    assert (race.track.name, race.vehicle.name) == ("togt_track", "rpg_quadrotor")


def test_a_name_of_the_file_that_is_a_path_stays_in_this_folder(hotlap, here, tmp_path):
    inner = tmp_path / "odd.urdf"
    inner.write_text((SAMPLES / "pybullet.urdf").read_text().replace('name="wasp"', 'name="../../the wasp"'))
    assert hotlap("import", str(inner)).code == 0
    assert load(here / "the-wasp.toml").name == "../../the wasp"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("nowhere.yaml",), "nowhere.yaml: there is no such file"),
        (("straight.toml",), "straight.toml: is a file of hotlap itself: hotlap check straight.toml"),
        ((DRONE, "--out", "straight.toml"), "straight.toml: exists already and is left as it is"),
        ((DRONE, "--out", "missing/kite.toml"), "missing/kite.toml: cannot be written: there is no folder missing"),
        ((DRONE, "--out", "kite.yaml"), "kite.yaml: must end with .toml"),
        ((DRONE, "--name", " "), "--name: must be a name, not ' '"),
        ((str(SAMPLES / "drone_models.toml"),), "describes 2 vehicles; choose one with --name: small, smaller"),
        ((), "FILE: is missing"),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(hotlap, here, arguments, message):
    before = sorted(here.iterdir())
    ran = hotlap("import", *arguments)
    assert (ran.code, ran.out, ran.err.count("\n")) == (2, "", 1)
    assert message in ran.err
    assert sorted(here.iterdir()) == before


def test_gates_are_read_from_a_simulator_that_runs(hotlap, here):
    with Server(
        Plant(load_quadrotor("airsim"), delayed=False), scene={"Gate0": ([4.0, 0.0, -2.0], [1.0, 0.0, 0.0, 0.0], [1.0] * 3)}
    ) as server:
        ran = hotlap("import", f"airsim://127.0.0.1:{server.port}", "--name", "hall")
    assert (ran.code, ran.err) == (0, "")
    assert ran.out.startswith("wrote hall.toml: a track, from the gates of a level of AirSim\n")
    assert load(here / "hall.toml").gates[0].position == (4.0, 0.0, 2.0)
    assert hotlap("check", "hall.toml").code == 0


def test_a_simulator_that_does_not_run_is_one_line(hotlap):
    ran = hotlap("import", "airsim://127.0.0.1:1")
    assert ran.code == 2
    assert "AirSim at 127.0.0.1:1: nobody listens there: is the simulator running" in ran.err
    assert ran.err.count("\n") == 1
