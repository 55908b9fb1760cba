"""`hotlap plan`: the reference, its figures and its files."""

from __future__ import annotations

import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from fake_world import make_scenario
from hotlap.reference.segmentation import SegmentationRule, SegmentClass, Segments
from hotlap.reference_files.csv import load_reference, save_reference


@pytest.mark.usefixtures("faked")
def test_figures_segments_and_a_map_for_people(hotlap):
    ran = hotlap("plan", "straight.toml")
    assert (ran.code, ran.err) == (0, "planning straight ...\n")
    assert ran.out.startswith("straight: 5 gates in 5.00 s\n")
    assert "  flat      0.00  2.50      2\n  ascent    2.50  5.00      3\n" in ran.out
    assert "from above: x" in ran.out
    assert "\x1b" not in ran.out


@pytest.mark.usefixtures("faked")
def test_json_has_the_keys_that_are_relied_on(hotlap):
    document = hotlap("plan", "straight.toml", "--json").document
    assert set(document) == {"race", "duration", "lap_time", "max_speed", "mean_speed", "cpu_time", "gates", "segments", "notes"}
    assert (document["race"], document["gates"], document["duration"]) == ("straight", 5, 5.0)
    assert document["segments"] == [
        {"class": "flat", "start": 0.0, "end": 2.5, "segment": 0},
        {"class": "ascent", "start": 2.5, "end": 5.0, "segment": 1},
    ]


@pytest.mark.usefixtures("faked")
def test_a_plan_that_is_written_is_one_that_can_be_read(hotlap, here):
    ran = hotlap("plan", "straight.toml", "--out", "plan.csv", "--json")
    assert ran.document["csv"] == "plan.csv"
    assert load_reference(here / "plan.csv", make_scenario().race).lap_time == pytest.approx(5.0, abs=0.05)


def test_a_reference_is_read_instead_of_planning(hotlap, here, monkeypatch):
    save_reference(here / "plan.csv", make_scenario().reference)
    monkeypatch.setattr("hotlap.planning.preparation.plan", lambda *_: pytest.fail("planned"))
    ran = hotlap("plan", "straight.toml", "--reference", "plan.csv", "--picture", "plan.svg", "--json")
    assert ran.code == 0, ran.err
    assert ran.document["picture"] == "plan.svg"
    assert "<svg" in (here / "plan.svg").read_text()
    assert ran.err == "reading plan.csv ...\n"
    assert ran.document["segments"][0]["class"] == "flat"


@pytest.mark.check
def test_planning_can_be_interrupted(here, environment):
    """Ctrl-C in the midst of the solver's own code ends it in order."""
    (here / "long.toml").write_text('base = "final-22"\n[planning]\nnodes = 100\n')  # takes half a minute
    command = [sys.executable, "-m", "hotlap", "plan", "long.toml"]
    process = subprocess.Popen(command, cwd=here, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    assert process.stderr.readline() == "planning long ...\n"
    time.sleep(1)  # into the solver, which may say a word of its own
    process.send_signal(signal.SIGINT)
    out, err = process.communicate()
    assert (process.returncode, out) == (130, "")
    assert err.splitlines()[-1] == "hotlap: interrupted; begin again with: hotlap plan long.toml"
    assert "Traceback" not in err


@pytest.mark.usefixtures("faked")
def test_a_rule_decides_about_the_segments(hotlap):
    asked = {rule: hotlap("plan", "straight.toml", "--segments", rule, "--json").document["segments"] for rule in SegmentationRule}
    assert [len(asked[rule]) for rule in ("paper", "released_1m", "released_3m", "none", "equal_time")] == [2, 1, 1, 1, 2]
    assert asked["paper"] == hotlap("plan", "straight.toml", "--json").document["segments"]


@pytest.mark.usefixtures("faked")
def test_pieces_that_share_have_the_number_of_their_segment(hotlap, monkeypatch):
    shared = Segments(np.array([0.0, 1.5, 3.5]), (SegmentClass.ASCENT, SegmentClass.FLAT, SegmentClass.ASCENT), 5.0, (0, 1, 0))
    monkeypatch.setattr("hotlap.planning.preparation.segment", lambda *_: shared)
    ran = hotlap("plan", "straight.toml", "--segments", "paper")
    rows = [line.split() for line in ran.out.splitlines() if line.startswith(("  ascent", "  flat"))]
    assert rows == [["ascent", "0.00", "1.50", "1", "1"], ["flat", "1.50", "3.50", "2", "2"], ["ascent", "3.50", "5.00", "2", "1"]]
    assert ran.out.endswith("1 ascent 0.0-1.5 s   2 flat 1.5-3.5 s   1 ascent 3.5-5.0 s\n")
    document = hotlap("plan", "straight.toml", "--segments", "paper", "--json").document
    assert [piece["segment"] for piece in document["segments"]] == [0, 1, 0]
