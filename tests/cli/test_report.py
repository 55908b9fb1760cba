"""`hotlap tune` writes a page, and `hotlap report` writes it again."""

from __future__ import annotations

import json
import re

import pytest

pytestmark = pytest.mark.usefixtures("faked")
EASY = ("tune", "straight.toml", "--seed", "1", "--validation", "50")


def document(path):
    """What the script of a page reads."""
    found = re.search(r'<script id="study-data" type="application/json">(.*?)</script>', path.read_text(encoding="utf-8"), re.DOTALL)
    assert found
    return json.loads(found[1])


def test_tuning_writes_a_page_and_says_where(hotlap, here):
    ran = hotlap(*EASY, "--out", "mine", "--json")
    assert ran.document["report"] == "mine/report.html"
    page = document(here / "mine" / "report.html")
    assert page["headline"]["flights"] == ran.document["flights"]
    assert page["configuration"]["command"] == f"hotlap {' '.join(EASY)}"
    assert re.search(r"report +mine/report\.html\n", hotlap(*EASY, "--out", "mine").out)


def test_the_page_is_written_again_as_it_was(hotlap, here):
    hotlap(*EASY, "--out", "mine")
    first = (here / "mine" / "report.html").read_bytes()
    (here / "mine" / "report.html").unlink()
    ran = hotlap("report", "mine", "--json")
    assert (ran.code, ran.document) == (0, {"study": "mine", "report": "mine/report.html", "figures": [], "video": None})
    assert (here / "mine" / "report.html").read_bytes() == first
    assert hotlap("report", "mine").out == "  report  mine/report.html\n"


def test_a_page_that_fails_costs_no_result(hotlap, here):
    (here / "mine" / "report.html").mkdir(parents=True)
    ran = hotlap(*EASY, "--out", "mine", "--json")
    assert (ran.code, ran.document["report"]) == (0, None)
    assert "note: no report: mine/report.html: cannot be written" in ran.err


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("report missing", "missing: holds no study (study.sqlite)"),
        ("report straight.toml", "straight.toml: holds no study (study.sqlite)"),
        ("report", "DIR: is missing; see hotlap report --help"),
        ("report mine --format gif", "--format: there is no format named 'gif'"),
        ("report mine --video lap.avi", "lap.avi: must end with .gif, .mp4"),
        ("report mine --video nowhere/lap.gif", "nowhere/lap.gif: cannot be written: there is no folder nowhere"),
    ],
)
def test_bad_input_is_one_clear_line(hotlap, line, said):
    ran = hotlap(*line.split())
    assert (ran.code, ran.out) == (2, "")
    assert ran.err.startswith(f"hotlap: {said}")
    assert ran.err.count("\n") == 1


def test_a_video_that_needs_what_is_not_there_is_refused_before_anything_is_flown(hotlap, monkeypatch):
    monkeypatch.setattr("hotlap.report.film.recording.find_ffmpeg", lambda: "")
    ran = hotlap("report", "missing", "--video", "lap.mp4")
    assert (ran.code, ran.out) == (2, "")
    assert ran.err.startswith("hotlap: lap.mp4: needs ffmpeg")
