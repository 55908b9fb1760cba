from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from cli.fake_hotlap import MODULES, REPLACEMENTS
from fake_world import make_scenario
from hotlap.cli import main
from hotlap.files.descriptions import save


@dataclass
class Ran:
    """How a command ended, and what it said."""

    code: int
    out: str
    err: str

    @property
    def document(self):
        return json.loads(self.out)


@pytest.fixture
def here(tmp_path, monkeypatch) -> Path:
    """An empty working folder, with caches of its own, that holds straight.toml: the race of the fake world."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOTLAP_CACHE", str(tmp_path / "cache"))
    for name in ("FORCE_COLOR", "NO_COLOR", "COLUMNS"):
        monkeypatch.delenv(name, raising=False)
    save(tmp_path / "straight.toml", make_scenario().race)
    return tmp_path


@pytest.fixture
def hotlap(here, capsys) -> Callable[..., Ran]:
    """The command line, in this process."""

    assert Path.cwd() == here

    def run(*arguments: str) -> Ran:
        code = main(list(arguments))
        return Ran(code, *capsys.readouterr())

    return run


@pytest.fixture
def faked(monkeypatch) -> None:
    """A world, a planner and pictures that take no time."""
    for place, name, value in REPLACEMENTS:
        monkeypatch.setattr(place, name, value, raising=False)
    for name, fake in MODULES.items():
        monkeypatch.setitem(sys.modules, name, fake)


@pytest.fixture
def environment(here) -> dict[str, str]:
    return {**os.environ, "HOTLAP_CACHE": str(here / "cache"), "PYTHONUNBUFFERED": "1"}
