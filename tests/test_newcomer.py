"""A newcomer's first hour: clone, tune, a drone and a track of one's own, two tuners, Python, export: no command ends it."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TRACK = """start = [-6.0, 0.0, 1.5]
[[gates]]
position = [0.0, 0.0, 1.5]
[[gates]]
position = [6.0, 3.0, 2.0]
[[gates]]
position = [12.0, 0.0, 1.5]
[[gates]]
position = [6.0, -3.0, 1.0]
"""
PROGRAM = """
import hotlap
tuned = hotlap.tune("circle-20", out="runs/python")
print(len(repr(tuned)), tuned.values.shape)
print(hotlap.Study("runs/python"))
tuned.plot()
"""


@pytest.mark.check
def test_from_a_clone_to_an_export_there_is_no_dead_end(tmp_path, record_property):
    clone, began = tmp_path / "hotlap", time.monotonic()
    home = {"HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / "cache"), "MPLBACKEND": "Agg"}  # nothing is there yet

    def run(*words: str, where: Path = clone) -> str:
        kept = {name: value for name, value in os.environ.items() if not name.startswith(("HOTLAP", "PYTEST", "PYTHON"))}
        done = subprocess.run(words, cwd=where, env={**kept, **home}, capture_output=True, text=True, check=False)
        record_property(" ".join(Path(word).name for word in words)[:60], f"{time.monotonic() - began:.0f} s")
        assert done.returncode == 0, f"{words}: {done.stdout[-1500:]}\n{done.stderr[-1500:]}"
        return done.stdout

    run("git", "clone", "--quiet", str(ROOT), str(clone), where=tmp_path)
    assert "confirmed" in run("make", "--silent", "tune", f"PYTHON={sys.executable}")
    hotlap = str(clone / ".venv/bin/hotlap")
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "my-track.toml").write_text(TRACK, encoding="utf-8")
    for words in (
        ("new", "quadrotor", "my-drone"),
        ("check", "my-drone.toml"),
        ("check", "my-track.toml"),
        ("new", "race", "my-race", "--vehicle", "my-drone.toml", "--track", "my-track.toml"),
        ("check", "my-race.toml"),
        ("tune", "my-race.toml", "--out", "runs/mine"),
        ("fly", "my-race.toml", "--parameters", "runs/mine", "--flights", "20"),
        ("compare", "circle-20", "--tuners", "gate_gp,random_search", "--seeds", "2", "--budget", "40", "--out", "runs/two"),
        ("export", "runs/mine", "--format", "acados"),
    ):
        run(hotlap, *words, where=mine)
    said = run(str(clone / ".venv/bin/python"), "-c", PROGRAM, where=mine)
    assert int(said.split()[0]) < 400  # characters of a result
    for made in ("runs/mine/report.html", "runs/two/comparison.html", "runs/python/report.html"):
        assert (mine / made).exists()
    record_property("from clone to export", f"{time.monotonic() - began:.0f} s")
