"""The examples run as they stand, are short, and use what is public."""

from __future__ import annotations

import ast
import runpy
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

import hotlap

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))
MOST_LINES = 40  # of code
SAYS = {
    "own_controller": "mean error: ",
    "own_cost": "tuned: passes all gates in ",
    "own_drone": "unknown latency",
    "own_simulator": "own_simulator.MySimulator:0.06 flies: 100 %",
    "own_track": "planned: ",
    "own_tuner": "own_tuner.Hill:bold  confirmed: ",
    "quickstart": "<TuningResult circle-34: completion=1 confirmed",
    "sampler_on_own_function": "guided walk: gain ",
    "robustness_check": "10 % heavier",
}
EVERY = pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
LONG = {"sampler_on_own_function"}
RUN = [pytest.param(path, marks=[pytest.mark.check] if path.stem in LONG else [], id=path.stem) for path in EXAMPLES]


def test_every_example_says_something_that_is_looked_for():
    assert {path.stem for path in EXAMPLES} == set(SAYS)


@pytest.mark.parametrize("path", RUN)
def test_it_runs_in_an_empty_folder_and_says_what_came_of_it(path, tmp_path, monkeypatch, capsys):
    """In this process, as if it had been started from the folder; warnings are errors in all tests."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [str(path.parent), *sys.path])
    monkeypatch.setattr(sys, "argv", [str(path)])
    runpy.run_path(str(path), run_name="__main__")
    said = capsys.readouterr()
    assert said.err == ""
    assert SAYS[path.stem] in said.out


@EVERY
def test_it_is_short(path):
    assert len([line for line in path.read_text(encoding="utf-8").splitlines() if line.strip()]) <= MOST_LINES


@EVERY
def test_it_uses_public_names(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module is not None and node.module.startswith("hotlap"):
            names = [alias.name for alias in node.names]
            assert not [name for name in names if name.startswith("_")]
            if node.module == "hotlap":
                assert [name for name in names if name not in hotlap.__all__ and find_spec(f"hotlap.{name}") is None] == []
