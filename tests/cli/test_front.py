"""`hotlap tune RACE --goal lap_time --hold ...`, with real plans and flights."""

from __future__ import annotations

import json

import pytest
from matplotlib.figure import Figure

import hotlap
from hotlap.analysis import front
from hotlap.api.front import FrontResult
from hotlap.cli import main
from hotlap.core.finite import finite
from hotlap.files.descriptions import load_parameters, load_race

TUNE = ["tune", "circle-20", "--goal", "lap_time", "--budget", "60", "--validation", "40", "--json"]


@pytest.fixture
def few_plans(monkeypatch):
    """A search that tries few plans."""
    monkeypatch.setattr(front, "LADDER", (0.8, 0.5))
    monkeypatch.setattr(front, "NARROWED", (0.5,))
    monkeypatch.setattr(front, "OTHERS", ())


@pytest.mark.check
@pytest.mark.usefixtures("few_plans")
def test_a_front_is_written_with_races_and_parameters_that_fly_it(tmp_path, capsys):
    out = tmp_path / "front"
    command = [*TUNE, "--hold", "mass=+5%, wind=0.5", "--out", str(out)]
    assert main(command) == 0
    document = json.loads(capsys.readouterr().out)
    assert document == json.loads((out / "front.json").read_text(encoding="utf-8"))
    assert [rate["change"] for rate in document["rates"]] == ["as tuned", "5 % heavier", "steady push of 0.5 m/s^2 as of wind"]
    assert all(rate["rate"] >= 0.95 and rate["low"] < rate["rate"] + 1e-9 for rate in document["rates"])
    laps = [one["lap_time"] for one in document["front"]]
    assert laps == sorted(laps)
    for one in document["front"]:
        assert load_race(one["race_file"]).name == load_parameters(one["parameters"]).race
    assert (out / "front.png").read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (out / "front.svg").read_text(encoding="utf-8")
    assert load_race(out / "race.toml").name == load_parameters(out).race == "circle-20-fastest"
    assert main(command) == 0  # nothing is flown twice
    again = capsys.readouterr()
    assert json.loads(again.out) == document
    assert "now" not in again.err
    found = hotlap.tune("circle-20", goal="lap_time", budget=60, validation=40, hold="mass=+5%, wind=0.5", out=out)
    assert isinstance(found, FrontResult)
    assert finite(found.to_dict()) == document
    assert found.lap_time == document["lap_time"]
    assert found.chosen is not None
    assert found.chosen.race == out / "race.toml"
    assert sum(row["best"] for row in found.rows()) == 1


@pytest.mark.check
@pytest.mark.usefixtures("few_plans")
def test_where_nothing_holds_the_front_says_what_is_stood(tmp_path, capsys):
    assert main([*TUNE[:-1], "--hold", "mass=+300%", "--out", str(tmp_path)]) == 1
    said = capsys.readouterr().out
    assert "no plan was found that holds under 1 condition in 95 % of the flights" in said
    assert "fly it again" not in said
    assert not (tmp_path / "race.toml").exists()
    document = json.loads((tmp_path / "front.json").read_text(encoding="utf-8"))
    assert document["lap_time"] is None
    found = hotlap.tune("circle-20", goal="lap_time", budget=60, validation=40, hold="mass=+300%", out=tmp_path)  # nothing is flown twice
    assert capsys.readouterr().out == ""
    assert isinstance(found, FrontResult)
    assert finite(found.to_dict()) == document
    assert (found.found, found.best, found.chosen, found.lap_time) == (False, None, None, None)
    assert repr(found).startswith("<FrontResult circle-20: no plan was found that holds under 1 condition")
    assert [row["lap_time"] for row in found.rows()] == sorted(point.lap for point in found.points)
    assert [row["lap_time"] for row in found.rows() if row["on_front"]] == [one["lap_time"] for one in document["front"]]
    assert all(0 <= row["300 % heavier"] <= 1 for row in found.rows())
    assert all(path.is_file() for path in (found.document, *found.pictures, *(place.race for place in found.places)))
    assert isinstance(found.plot(), Figure)


def test_a_condition_that_cannot_be_read_is_refused_before_anything_is_planned(tmp_path, capsys):
    assert main([*TUNE, "--hold", "mas=+5%", "--out", str(tmp_path / "none")]) == 2
    assert "did you mean mass?" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()
