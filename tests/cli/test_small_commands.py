"""`hotlap races`, `check`, `new` and `bench`."""

from __future__ import annotations

import sys
from types import ModuleType

import pytest

from fake_world import make_scenario
from hotlap.files.descriptions import Kind, load, names
from hotlap.planning import cache, problem


def test_every_built_in_race_is_listed(hotlap):
    ran = hotlap("races")
    assert (ran.code, ran.err) == (0, "")
    header, *lines = ran.out.splitlines()
    assert header.split()[:3] == ["race", "track", "gates"]
    assert tuple(line.split()[0] for line in lines) == names(Kind.RACE)
    assert all(len(line) <= 140 for line in lines)


def test_races_as_json(hotlap):
    rows = {row["name"]: row for row in hotlap("races", "--json").document["races"]}
    assert set(rows) == set(names(Kind.RACE))
    assert (rows["circle-34"]["track"], rows["circle-34"]["gates"], rows["circle-34"]["v_max"]) == ("circle", 12, 34.0)
    assert rows["airsim-final-22"]["difficulty"] == "beyond the vehicle"
    assert rows["split-s"]["v_max"] is None


@pytest.mark.parametrize(("name", "kind"), [("circle-34", "race"), ("circle", "track"), ("hummingbird", "quadrotor")])
def test_check_says_what_anything_means(hotlap, name, kind):
    ran = hotlap("check", name)
    assert (ran.code, ran.err) == (0, "")
    assert ran.out.startswith(f"{kind} {name}\n")
    document = hotlap("check", name, "--json").document
    assert (document["kind"], document["name"]) == (kind, name)
    assert all(set(finding) == {"label", "value", "remark", "level"} for finding in document["findings"])
    assert all(finding["label"] in ran.out for finding in document["findings"])


def test_warnings_are_marked_in_words_and_coloured_on_terminals(hotlap, monkeypatch):
    ran = hotlap("check", "airsim-final-22")
    assert "warning: " in ran.out
    assert "\x1b[" not in ran.out
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert "\x1b[1;31m" in hotlap("check", "airsim-final-22").out


def test_check_knows_the_top_speed_of_a_race_that_was_planned(hotlap):
    assert "top speed about " in hotlap("check", "straight.toml").out
    reference = make_scenario().reference
    cache.save(cache.key(problem.Problem.of(make_scenario().race)), reference)
    assert f"top speed {reference.speeds.max():.0f} m/s" in hotlap("check", "straight.toml").out


@pytest.mark.parametrize("kind", list(Kind))
def test_new_writes_a_file_that_checks(hotlap, here, kind):
    ran = hotlap("new", kind, "mine")
    assert (ran.code, ran.err) == (0, "")
    assert ran.out == "wrote mine.toml; edit it, then: hotlap check mine.toml\n"
    assert load(here / "mine.toml").name == "mine"
    assert hotlap("check", "mine.toml").code == 0


def test_a_drone_a_track_and_a_race_of_ones_own_are_four_commands(hotlap):
    hotlap("new", "quadrotor", "kite")
    hotlap("new", "track", "garden")
    assert hotlap("new", "race", "sunday", "--track", "garden.toml", "--vehicle", "kite.toml").code == 0
    ran = hotlap("check", "sunday.toml")
    assert [line.split()[:2] for line in ran.out.splitlines()[1:3]] == [["track", "garden"], ["vehicle", "kite"]]
    assert "warning" not in ran.out
    assert ran.out.endswith("next: hotlap tune sunday.toml\n")


def test_check_says_what_to_do_next(hotlap):
    assert hotlap("check", "circle").out.endswith("next: hotlap new race NAME --track circle\n")
    assert hotlap("check", "hummingbird").out.endswith("next: hotlap new race NAME --vehicle hummingbird\n")
    assert hotlap("check", "airsim-final-22").out.endswith("next: see to the warnings, then hotlap tune airsim-final-22\n")


def test_a_track_is_drawn_with_its_gates_numbered(hotlap):
    out = hotlap("check", "circle").out
    assert "from above: " in out
    assert "from the side: " in out
    assert "S" in out.split("from above: ")[1]


def test_a_name_without_its_ending_is_told_the_file(hotlap):
    ran = hotlap("check", "straight")
    assert (ran.code, ran.err) == (2, "hotlap: there is no race, track or quadrotor named 'straight'; the file is straight.toml\n")


def test_new_takes_a_path_and_tells_programs(hotlap, here):
    (here / "drones").mkdir()
    ran = hotlap("new", "quadrotor", "drones/fast one.toml", "--json")
    assert ran.document == {"kind": "quadrotor", "name": "fast one", "file": "drones/fast one.toml"}
    assert load(here / "drones" / "fast one.toml").name == "fast one"


class Bench:
    def dump(self):
        return {"machine": "this one", "threads": 2}

    def lines(self):
        return ["fast enough"]


def test_bench_measures_and_prints(hotlap, monkeypatch):
    module = ModuleType("hotlap.analysis.speed")
    vars(module).update(STAGES=1, measure=lambda report: report("measuring ...") or Bench())
    monkeypatch.setitem(sys.modules, "hotlap.analysis.speed", module)
    monkeypatch.delitem(sys.modules, "hotlap.cli.bench", raising=False)
    ran = hotlap("bench")
    assert (ran.code, ran.out, ran.err) == (0, "fast enough\n", "measuring ...\n")
    assert hotlap("bench", "--json").document == Bench().dump()
    monkeypatch.delitem(sys.modules, "hotlap.cli.bench", raising=False)
