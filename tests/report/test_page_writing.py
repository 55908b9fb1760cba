"""A page is whole, says the same without JavaScript, and lets no name of a user's become markup."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from fake_world import make_scenario
from hotlap.core.errors import InputError, StudyError
from hotlap.report.page import writing
from hotlap.report.page.replay import replay_finished
from hotlap.report.page.static import render_static, summary_of
from hotlap.report.page.static_map import draw_track_map
from hotlap.report.page.writing import DATA, REPORT, STATIC, TITLE, LiveStudy, fill, load_template, render, write_report
from hotlap.report.scene import stage
from hotlap.study.snapshot import read_snapshot
from hotlap.study.study import Study
from hotlap.tuning.objective import Objective
from plausible_world import PlausibleWorld
from studies import AnyVehicle, begin, carry, configure

TEMPLATE = f"<head>{TITLE}</head><body>{STATIC}{DATA}</body>"
VOID = {"meta", "br", "link", "img", "input", "hr"}


class Balanced(HTMLParser):
    """Every element that is opened is closed."""

    def __init__(self):
        super().__init__()
        self.open, self.words, self.seen = [], [], []

    def handle_starttag(self, tag, attrs):  # noqa: ARG002
        self.seen.append(tag)
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def read(html):
    parser = Balanced()
    parser.feed(html)
    parser.close()
    assert parser.open == []
    return parser


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return carry(tmp_path_factory.mktemp("study"), configure(), command="hotlap tune 'a & b.toml'")


@pytest.fixture(scope="module")
def replay(study):
    return replay_finished(study.configuration, AnyVehicle(), study.best)


def test_the_built_page_has_its_places(study, replay):
    html = render(study, replay)
    assert html.startswith("<!")
    assert html.count("<title>straight: metropolis_hastings:tied - hotlap</title>") == 1
    (data,) = re.findall(r'<script id="study-data" type="application/json">(.*?)</script>', html, re.DOTALL)
    assert json.loads(data)["headline"]["race"] == "straight"
    assert '<div id="static"><h1>' in html


@pytest.mark.parametrize("place", [TITLE, STATIC, DATA])
def test_the_template_has_each_place_once(place):
    assert load_template().count(place) == 1


def test_a_name_that_looks_like_markup_stays_a_name():
    name = "</title></script><script>alert(1)</script>"
    html = fill(TEMPLATE, name, "", {"name": name})
    assert html.count("<script") == 1
    assert html.count("</title>") == 1


def test_without_javascript_the_answers_are_there(study, replay):
    page = read(render_static(study, replay))
    words = " ".join(page.words)
    assert summary_of(study) in words
    assert {"svg", "table", "h1", "figure"} <= set(page.seen)
    assert "script" not in page.seen
    for part in ("robustness", "as tuned", "of 50 flights", *study.configuration.scenario.space.names, study.command):
        assert part.lower() in words.lower()


def test_a_goal_that_was_not_confirmed_is_said_as_plainly(tmp_path):
    snapshot = carry(tmp_path, configure(goal="mean_error<0.01"))
    assert "NOT confirmed in 20 flights" in summary_of(snapshot)


@pytest.mark.parametrize(("goal", "told"), [("completion=1", True), ("none", False)])
def test_a_study_that_failed_says_why_without_javascript(tmp_path, goal, told):
    world = PlausibleWorld(reach=40.0)
    study = carry(tmp_path, configure(goal=goal, budget=10), world)
    words = " ".join(read(render_static(study, replay_finished(study.configuration, world, study.best))).words)
    assert ("Why it failed" in words) == ("50 of 50 new flights missed gate 1" in words) == told


def test_a_study_that_passed_all_gates_says_that_its_goal_asks_for_more(tmp_path):
    world = PlausibleWorld(reach=0.0)  # all flights pass
    study = carry(tmp_path, configure(goal="mean_error<0.0001", budget=10), world)
    words = " ".join(read(render_static(study, replay_finished(study.configuration, world, study.best))).words)
    assert "all 50 new flights passed every gate, but the goal (mean_error<0.0001) asks for more" in words


def failed_but(folder, replayed):
    """A study that found nothing, and the flights of its page in another world."""
    study = carry(folder, configure(goal="completion=1", budget=10), PlausibleWorld(reach=40.0))
    return study, replay_finished(study.configuration, replayed, study.best)


def test_a_goal_that_all_new_flights_meet_does_not_ask_for_more(tmp_path):
    words = " ".join(read(render_static(*failed_but(tmp_path, PlausibleWorld(reach=0.0)))).words)
    assert "all 50 new flights passed every gate, but the goal (completion=1) was not confirmed in the search" in words


@pytest.mark.parametrize("known", [0, 7])
def test_flights_whose_end_is_not_known_are_not_taken_for_complete(tmp_path, known):
    study, replay = failed_but(tmp_path, PlausibleWorld(reach=40.0))
    tuned, *others = replay.scene.repeats
    tuned = replace(tuned, failures=tuned.failures[:known], failed_gates=tuned.failed_gates[:known], ends=tuned.ends[:known])
    words = " ".join(read(render_static(study, replace(replay, scene=replace(replay.scene, repeats=(tuned, *others))))).words)
    assert f"{50 - known} of 50 new flights did not pass every gate, and where they ended is not known" in words
    assert ("7 of 50 new flights missed gate 1" in words) == bool(known)
    assert "all 50" not in words


def test_a_study_without_flights_has_a_page(tmp_path):
    snapshot = begin(tmp_path, configure())
    assert summary_of(snapshot) == "No flights yet."
    read(render_static(snapshot, None))


def test_the_map_stays_within_its_box():
    svg = draw_track_map(stage(make_scenario()))
    width, height = map(float, re.search(r'viewBox="0 0 (\S+) (\S+)"', svg).groups())
    points = [tuple(map(float, pair.split(","))) for line in re.findall(r'points="([^"]*)"', svg) for pair in line.split()]
    assert points
    assert all(0 <= x <= width and 0 <= y <= height for x, y in points)
    read(svg)


def test_a_report_lies_in_the_folder_of_its_study(tmp_path):
    with Study.open(tmp_path, configure()) as study:
        path = write_report(study, PlausibleWorld())
    assert path == tmp_path / REPORT
    assert not list(tmp_path.glob("*.part"))


def test_a_report_that_cannot_be_written_is_one_clear_line(tmp_path):
    with Study.open(tmp_path, configure()) as study:
        (tmp_path / REPORT).mkdir()
        with pytest.raises(InputError, match=r"report\.html: cannot be written"):
            write_report(study, PlausibleWorld())


def test_a_page_is_small(study, replay):
    assert len(render(study, replay)) - len(load_template()) < 1_000_000


@pytest.fixture
def reads(monkeypatch):
    """Every time that a study is read as a whole."""
    done = []
    read_snapshot = writing.read_snapshot

    def count(study):
        done.append(study)
        return read_snapshot(study)

    monkeypatch.setattr(writing, "read_snapshot", count)
    return done


class CountingWorld(PlausibleWorld):
    """Counts how often it is asked to fly."""

    calls = 0

    def fly(self, *args, **kwargs):
        self.calls += 1
        return super().fly(*args, **kwargs)


def test_a_poll_reads_the_study_only_when_flights_were_added(tmp_path, reads):
    asked, world = configure(goal="none", budget=6, validation=0), CountingWorld()
    carry(tmp_path, asked)
    live = LiveStudy(tmp_path, world)
    known = json.loads(live.news())["flights"]["number"]["shape"][0]
    flown = world.calls
    assert known == 6
    assert [live.news(known) for _ in range(5)] == [None] * 5
    assert (len(reads), world.calls) == (1, flown)
    carry(tmp_path, configure(goal="none", budget=9, validation=0))
    assert json.loads(live.news(known))["flights"]["number"]["shape"] == [9]
    assert live.news(9) is None
    assert len(reads) == 2


def test_a_poll_of_a_study_that_is_gone_is_one_clear_line(tmp_path):
    begin(tmp_path, configure())
    live = LiveStudy(tmp_path, PlausibleWorld())
    assert '"state":"running"' in live.page()
    (tmp_path / "study.sqlite").unlink()
    with pytest.raises(StudyError, match="cannot be opened"):
        live.news(0)


def test_what_was_asked_for_stands_first_and_is_marked(tmp_path):
    asked = configure()
    with Study.open(tmp_path, asked, hold="wind=3, mass=+10%") as opened:
        opened.run(Objective(asked.scenario, AnyVehicle(), asked.metric))
        study = read_snapshot(opened)
    assert "--hold 'wind=3, mass=+10%'" in study.command
    replay = replay_finished(asked, AnyVehicle(), study.best, hold=study.hold)
    assert [one.asked for one in replay.robustness] == [False, True, True, False, False, False, False]
    words = " ".join(read(render_static(study, replay)).words)
    assert "asked for" in words
    assert words.index("steady push of 3 m/s^2 as of wind") < words.index("10 % heavier") < words.index("10 % lighter")
    html = render(study, replay)
    assert html.count('"asked":true') == 2
