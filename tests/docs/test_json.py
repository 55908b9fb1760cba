"""What the documentation says of `--json` is there."""

from __future__ import annotations

import json
import re

import pytest

from docs.pages import DOCS, ROOT
from hotlap.cli import main

ROW = re.compile(r"^\| `(\w+)` \| (.*) \|$", re.MULTILINE)
COMMANDS = {
    "races": [],
    "tracks": [],
    "quadrotors": [],
    "tuners": [],
    "worlds": [],
    "check": ["circle-34"],
    "cache": [],
    "completion": ["bash"],
    "new": ["track", "mine"],
    "import": [str(ROOT / "tests" / "importers" / "samples" / "mrs.yaml")],
    "identify": ["flight.csv", "--quadrotor", "hummingbird"],
    "plan": ["circle-34"],
    "tune": ["circle-34", "--validation", "10", "--hold", "thrust=-40%", "--out", "study"],
    "fly": ["circle-34", "--flights", "2"],
    "export": ["study", "--format", "csv"],
    "report": ["study"],
    "landscape": ["circle-34", "--points", "2"],
    "compare": [
        "circle-20",
        "--tuners",
        "random_search,cma_es",
        "--seeds",
        "1",
        "--budget",
        "10",
        "--validation",
        "2",
        "--out",
        "comparison",
    ],
}


STUDY = ["tune", "circle-34", "--validation", "0", "--out", "study", "--json"]
FLIGHT = ["fly", "circle-34", "--flights", "1", "--log", "flight.csv", "--json"]
BEFORE = {"export": STUDY, "report": STUDY, "identify": FLIGHT}  # what a command needs to have run
LONG = {"tune", "export", "report", "compare", "identify"}  # commands that tune or fit


def documented():
    _, section = (DOCS / "commands.md").read_text(encoding="utf-8").split("## JSON")
    return {command: set(re.findall(r"`(\w+)`", keys)) for command, keys in ROW.findall(section)}


def keys_of(value):
    """All keys of a document, those of its tables included."""
    if isinstance(value, dict):
        return set(value).union(*map(keys_of, value.values()))
    return set().union(*map(keys_of, value)) if isinstance(value, list) else set()


def test_every_command_that_is_quick_is_looked_at():
    others = {
        "bench",
        "watch",
        "transfer",
        "score",
        "lap",
    }  # the last three: tests/api/test_transfer.py, test_score.py, tests/cli/test_lap.py
    assert set(documented()) == {*COMMANDS, *others}


@pytest.mark.parametrize("command", [pytest.param(name, marks=[pytest.mark.check] * (name in LONG)) for name in COMMANDS])
def test_keys_that_can_be_relied_on_are_there(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    if command in BEFORE:
        main(BEFORE[command])
        capsys.readouterr()
    main([command, *COMMANDS[command], "--json"])
    assert documented()[command] <= keys_of(json.loads(capsys.readouterr().out))


def test_every_figure_of_check_is_documented(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    figures = set()
    for name in ("circle", "three-inch", "x500", "circle-34"):
        main(["check", name, "--json"])
        figures |= {figure for finding in json.loads(capsys.readouterr().out)["findings"] for figure in finding["figures"]}
    said = set(re.findall(r"`(\w+)`", (DOCS / "commands.md").read_text(encoding="utf-8").split("| of | `figures` |")[1]))
    assert figures - said == set()
