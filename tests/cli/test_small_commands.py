"""`hotlap races`, `check`, `new` and `bench`."""

from __future__ import annotations

import os
import sys
from types import ModuleType, SimpleNamespace

import pytest

from hotlap.cli.check import wrap_remarks
from hotlap.files.descriptions import Kind, load, names
from printed_figures import check_figures


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


@pytest.mark.usefixtures("faked")
@pytest.mark.parametrize(("name", "kind"), [("straight.toml", "race"), ("circle", "track"), ("hummingbird", "quadrotor")])
def test_check_says_what_anything_means(hotlap, name, kind):
    ran = hotlap("check", name)
    assert ran.code == 0
    assert all(line.endswith(" ...") for line in ran.err.splitlines())
    assert bool(ran.err) == (kind == "race")
    name, file = name.removesuffix(".toml"), name
    assert ran.out.startswith(f"{kind} {name}\n")
    document = hotlap("check", file, "--json").document
    assert (document["kind"], document["name"]) == (kind, name)
    assert all(set(finding) == {"label", "value", "remark", "level", "figures"} for finding in document["findings"])
    numbers = [value for finding in document["findings"] for value in finding["figures"].values()]
    assert len(numbers) >= 5
    assert all(value is None or isinstance(value, int | float) for value in numbers)
    for finding in document["findings"]:
        check_figures(SimpleNamespace(**finding))
    assert all(finding["label"] in ran.out for finding in document["findings"])


SLOW_MOTORS = 'base = "hummingbird"\nrate_gain = [60.0, 60.0, 8.0]\n'


def test_warnings_are_marked_in_words_and_coloured_on_terminals(hotlap, here, monkeypatch):
    (here / "slow.toml").write_text(SLOW_MOTORS)
    ran = hotlap("check", "slow.toml")
    assert "warning: " in ran.out
    assert "\x1b[" not in ran.out
    assert ran.out.endswith("next: see to the warnings, then hotlap new race NAME --vehicle slow.toml\n")
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert "\x1b[1;31m" in hotlap("check", "slow.toml").out


@pytest.mark.usefixtures("faked")
def test_check_flies_as_often_as_it_is_asked_to(hotlap):
    found = {finding["label"]: finding for finding in hotlap("check", "straight.toml", "--flights", "20", "--json").document["findings"]}
    assert found["default weights"]["value"].endswith(" of 20 flights complete")
    labels = {finding["label"] for finding in hotlap("check", "straight.toml", "--flights", "0", "--json").document["findings"]}
    assert set(found) - labels >= {"default weights", "mean error", "difficulty"}


@pytest.mark.usefixtures("faked")
def test_the_next_command_asks_for_what_was_checked(hotlap):
    ran = hotlap("check", "straight.toml", "--controller", "geometric", "--segments", "none", "--flights", "0")
    assert ran.out.endswith("hotlap tune straight.toml --segments none --controller geometric\n")


@pytest.mark.parametrize("option", ["--reference", "--controller"])
def test_what_only_a_race_has_is_refused_for_a_track(hotlap, option):
    ran = hotlap("check", "circle", option, {"--reference": "straight.toml", "--controller": "mpc"}[option])
    assert (ran.code, ran.err) == (2, f"hotlap: {option}: is of a race, not of a track\n")


@pytest.mark.check
@pytest.mark.parametrize("kind", list(Kind))
def test_new_writes_a_file_that_checks(hotlap, here, kind):
    ran = hotlap("new", kind, "mine")
    assert (ran.code, ran.err) == (0, "")
    assert ran.out == "wrote mine.toml; edit it, then: hotlap check mine.toml\n"
    assert load(here / "mine.toml").name == "mine"
    assert hotlap("check", "mine.toml", *(["--flights", "0"] if kind is Kind.RACE else [])).code == 0


@pytest.mark.check
def test_a_drone_a_track_and_a_race_of_ones_own_are_four_commands(hotlap):
    hotlap("new", "quadrotor", "kite")
    hotlap("new", "track", "garden")
    assert hotlap("new", "race", "sunday", "--track", "garden.toml", "--vehicle", "kite.toml").code == 0
    ran = hotlap("check", "sunday.toml", "--flights", "0")
    assert [line.split()[:2] for line in ran.out.splitlines()[1:3]] == [["track", "garden"], ["vehicle", "kite"]]
    assert "warning" not in ran.out
    assert ran.out.endswith("next: hotlap tune sunday.toml\n")


def test_check_says_what_to_do_next(hotlap):
    assert hotlap("check", "circle").out.endswith("next: hotlap new race NAME --track circle\n")
    assert hotlap("check", "hummingbird").out.endswith("next: hotlap new race NAME --vehicle hummingbird\n")


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


def test_findings_keep_within_the_terminal_and_lose_no_word(hotlap, monkeypatch):
    whole = hotlap("check", "hummingbird").out
    assert "COLUMNS" not in os.environ
    for columns in (60, 112):
        monkeypatch.setenv("COLUMNS", str(columns))
        told = hotlap("check", "hummingbird").out
        assert max(map(len, told.splitlines())) <= columns
        assert told.split() == whole.split()


def test_remarks_go_on_from_their_values_where_columns_are_too_wide():
    rows = [("lag", "95 ms", "rates follow"), ("first guess", "50 of 50", "")]
    assert wrap_remarks(rows, None) == wrap_remarks(rows, 60) == [["  lag          95 ms     rates follow"], ["  first guess  50 of 50"]]
    assert wrap_remarks(rows, 30) == [["  lag          95 ms  rates", "               follow"], ["  first guess  50 of 50"]]
