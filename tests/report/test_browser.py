"""The page of a real study in a real browser: it plays, its parts are linked, nothing is missing, and it follows a study that runs."""

from __future__ import annotations

import fcntl
import json
import os
import shutil
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from comparisons import make_comparison
from hall import make_hall
from hotlap.report.comparison_article import compose_article
from hotlap.report.page.replay import replay_finished
from hotlap.report.page.writing import render
from hotlap.report.server import Server
from hotlap.report.studies_page import StudiesPage
from hotlap.study.study import Study
from hotlap.tuning.objective import Objective
from plausible_world import PlausibleWorld
from studies import begin, carry, configure

PAGE = Path(__file__).parents[2] / "page"
CHROMIUM = os.environ.get("CHROMIUM", "/usr/bin/chromium")
HOTLAP = [sys.executable, "-m", "hotlap"]
RACE = ("circle-34", "--first-guess", "default", "--seed", "0")
LONG = "mass=+10% & thrust=-15% & wind=3 & gusts=2"  # a condition with a long name
FLOWN = "50 new flights with the tuned parameters"
OLDEST_NODE = 18

pytestmark = pytest.mark.check


def missing() -> str:
    """What a browser test needs and this machine lacks; "" for nothing."""
    node = shutil.which("node")
    if node is None or shutil.which("npm") is None:
        return "node or npm is not installed"
    version = subprocess.run([node, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    if int(version.removeprefix("v").split(".")[0]) < OLDEST_NODE:
        return f"node {version} is older than {OLDEST_NODE}"
    return "" if Path(CHROMIUM).exists() else f"{CHROMIUM} is not installed"


@pytest.fixture(scope="module", autouse=True)
def tools():
    """Chromium, node, and what the page's tests take from npm."""
    reason = missing()
    if reason and os.environ.get("CI"):
        pytest.fail(f"the page must be tested in a browser, but {reason}")
    if reason:
        pytest.skip(reason)
    with (PAGE / "package-lock.json").open() as lock:  # processes of one test run must not install at the same time
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not all((PAGE / "node_modules" / name).is_dir() for name in ("playwright-core", "axe-core")):
            subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], cwd=PAGE, check=True, capture_output=True)


def hotlap(*words: str) -> None:
    done = subprocess.run([*HOTLAP, *words], capture_output=True, text=True, check=False)
    assert done.returncode in {0, 1}, done.stderr  # 1: the goal was not reached in so few flights


def drive(*words: str) -> None:
    done = subprocess.run(["node", *words], cwd=PAGE, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_the_page_of_a_study_does_what_it_should(tmp_path):
    hotlap("tune", *RACE, "--budget", "40", "--validation", "40", "--hold", LONG, "--out", str(tmp_path / "study"))
    drive("browser/study.mjs", str(tmp_path / "study/report.html"), str(tmp_path / "pictures"), "long")
    assert {path.name for path in (tmp_path / "pictures").iterdir()} == {"desktop.png", "phone.png", "print.pdf", "without-script.png"}
    drive("browser/tool.mjs", str(tmp_path / "study/report.html"), str(tmp_path / "pictures"))


def test_the_page_of_a_study_that_failed_says_why(tmp_path):
    world = PlausibleWorld(reach=40.0)  # no parameters but the optimum pass a gate
    study = carry(tmp_path / "study", configure(goal="completion=1", budget=20), world)
    page = tmp_path / "failed.html"
    page.write_text(render(study, replay_finished(study.configuration, world, study.best)), encoding="utf-8")
    drive("browser/failed.mjs", str(page), str(tmp_path / "pictures"))


@pytest.mark.parametrize(
    ("reach", "known", "words"),
    [
        (0.0, 0, f"all {FLOWN} passed every gate, but the goal (completion=1) was not confirmed in the search"),
        (40.0, 0, f"50 of {FLOWN} did not pass every gate"),
        (40.0, 50, f"50 of {FLOWN} did not pass every gate: 50 missed gate 1"),
    ],
)
def test_the_verdict_says_what_the_new_flights_have_shown(tmp_path, reach, known, words):
    study = carry(tmp_path / "study", configure(goal="completion=1", budget=10), PlausibleWorld(reach=40.0))
    replay = replay_finished(study.configuration, PlausibleWorld(reach=reach), study.best)
    tuned, *others = replay.scene.repeats
    tuned = replace(tuned, failures=tuned.failures[:known], failed_gates=tuned.failed_gates[:known], ends=tuned.ends[:known])
    page = tmp_path / "verdict.html"
    page.write_text(render(study, replace(replay, scene=replace(replay.scene, repeats=(tuned, *others)))), encoding="utf-8")
    drive("browser/verdict.mjs", str(page), words)


def test_a_track_with_openings_and_obstacles_is_drawn_from_every_camera(tmp_path):
    page = tmp_path / "hall.html"
    page.write_text(render(begin(tmp_path / "study", configure(make_hall())), None), encoding="utf-8")
    drive("browser/hall.mjs", str(page))


def test_the_page_follows_a_study_that_runs(tmp_path):
    asked = ("tune", *RACE, "--goal", "none", "--validation", "0", "--out", str(tmp_path / "study"))
    hotlap(*asked, "--budget", "6")
    with start(*HOTLAP, "watch", str(tmp_path / "study"), "--port", "0", "--json") as server:
        browser = start("node", "browser/live.mjs", read_document(server)["address"])
        try:
            assert browser.stdout is not None
            assert browser.stdout.readline().strip() == "ready"
            hotlap(*asked, "--budget", "12")
            _, complaints = browser.communicate(timeout=240)
        finally:
            browser.kill()
            server.terminate()
    assert browser.returncode == 0, complaints


def test_the_page_of_a_comparison_can_be_read_sorted_and_sifted_at_any_size_and_in_the_dark(tmp_path):
    page = tmp_path / "comparison.html"
    page.write_text(compose_article(make_comparison(), "runs.jsonl", f"hotlap compare {'a-long-name-' * 12}").html, encoding="utf-8")
    drive("browser/comparison.mjs", str(page), str(tmp_path / "pictures"))
    drive("browser/axe.mjs", str(page))
    assert len(list((tmp_path / "pictures").iterdir())) == 4


def test_the_page_of_a_folder_of_studies_is_sifted_sorted_and_follows_them(tmp_path):
    studies, asked = tmp_path / "studies", configure(goal="none", budget=20, validation=0)
    carry(studies / "done-0", configure(budget=20))
    for k in range(1, 60):
        shutil.copytree(studies / "done-0", studies / f"done-{k}")
    begin(studies / "below" / "new", asked)
    page = StudiesPage(studies, lambda _: Told())
    with Server(page, "127.0.0.1", 0, page.study) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        browser = start("node", "browser/studies.mjs", server.address, str(tmp_path / "pictures"))
        try:
            assert browser.stdout is not None
            assert browser.stdout.readline().strip() == "ready"
            with Study.open(studies / "below" / "new", asked) as study:
                study.run(Objective(asked.scenario, PlausibleWorld(), asked.metric))
            _, complaints = browser.communicate(timeout=240)
        finally:
            browser.kill()
            server.shutdown()
    assert browser.returncode == 0, complaints


class Told:
    """The page of a study that is not what is tested."""

    def page(self) -> str:
        return '<!doctype html><html lang="en"><head><title>study</title></head><body>study</body></html>'

    def news(self, known: int = -1) -> str | None:  # noqa: ARG002
        return None


def start(*words: str) -> subprocess.Popen[str]:
    return subprocess.Popen(words, cwd=PAGE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def read_document(process: subprocess.Popen[str]) -> dict[str, str]:
    """The JSON document at the beginning of what a process prints."""
    assert process.stdout is not None
    text = ""
    for line in process.stdout:
        text += line
        try:
            return json.loads(text)
        except json.JSONDecodeError:
            continue
    raise AssertionError(text)
