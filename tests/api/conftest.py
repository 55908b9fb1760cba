from __future__ import annotations

import sys

import pytest

from cli.fake_hotlap import MODULES, REPLACEMENTS
from fake_world import make_scenario
from hotlap.files.descriptions import save


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty working folder with straight.toml, and a world and a planner that take no time."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOTLAP_CACHE", str(tmp_path / "cache"))
    for place, name, value in REPLACEMENTS:
        monkeypatch.setattr(place, name, value, raising=False)
    for name, fake in MODULES.items():
        monkeypatch.setitem(sys.modules, name, fake)
    save(tmp_path / "straight.toml", make_scenario().race)
    return tmp_path
