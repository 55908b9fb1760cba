"""What is kept is not computed again, unless the code that computes it is another."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

import pytest

from hotlap.analysis import resumable
from hotlap.analysis.resumable import DECIDING, ResumableJobs, digest_code
from test_floors import FLOOR_OF, FLOORS

NO_MATTER = {"system", "files", "importers", "feasibility", "logs", "identification", "real_flight"}  # of a flight: their keys say it


def double(piece: int) -> Iterator[int]:
    yield 2 * piece


class Counted:
    """Progress and remarks, written down."""

    def __init__(self) -> None:
        self.said, self.notes = [], []

    @contextmanager
    def progress(self, unit, wanted, done):
        self.said.append(f"{done} of {wanted} {unit}")
        yield self.said.append


@pytest.fixture
def heard() -> Counted:
    return Counted()


@pytest.fixture
def jobs(tmp_path, heard) -> ResumableJobs:
    return ResumableJobs(tmp_path, 1, heard.progress, heard.notes.append)


def by_other_code(monkeypatch, jobs: ResumableJobs) -> ResumableJobs:
    """The same jobs, after a change of a source."""
    monkeypatch.setattr(resumable, "digest_code", lambda module: f"another {module}")
    return ResumableJobs(jobs.folder, jobs.processes, jobs.progress, jobs.note)


def test_each_piece_is_computed_once_and_results_come_in_the_order_asked(jobs, heard):
    assert jobs.each("numbers", {"three": 3, "one": 1}, double) == {"three": 6, "one": 2}
    assert jobs.each("numbers", {"one": 1, "two": 2, "three": 3}, double) == {"one": 2, "two": 4, "three": 6}
    assert heard.said == ["0 of 2 numbers", "three", "one", "2 of 3 numbers", "two"]


def test_a_piece_of_the_same_name_and_another_content_is_another(jobs):
    assert jobs.each("numbers", {"a": 3}, double) == {"a": 6}
    assert jobs.each("numbers", {"a": 4}, double) == {"a": 8}


def test_results_of_other_code_are_computed_again_which_is_said_in_one_line(jobs, heard, monkeypatch):
    jobs.each("numbers", {"one": 1, "two": 2, "three": 3}, double)
    later = by_other_code(monkeypatch, jobs)
    assert heard.notes == []
    heard.said.clear()
    later.each("numbers", {"one": 1, "two": 2}, double)
    later.each("numbers", {"one": 1, "two": 2, "three": 3}, double)
    assert heard.said == ["0 of 2 numbers", "one", "two", "2 of 3 numbers", "three"]
    assert heard.notes == [f"{jobs.folder / 'lines.jsonl'}: results of other source code than this are not used; they are computed again"]
    heard.notes.clear()
    by_other_code(monkeypatch, jobs).each("numbers", {"one": 1}, double)
    assert heard.notes == [], "all of them have been computed again"


def test_a_line_says_which_code_has_made_it(jobs):
    jobs.each("numbers", {"one": 1}, double)
    (line,) = (jobs.folder / "lines.jsonl").read_text(encoding="utf-8").splitlines()
    assert json.loads(line)["code"] == digest_code(__name__)


def test_the_code_of_a_result_is_that_of_all_packages_below_a_study_and_of_what_computes_it():
    below = {name for name, floor in FLOOR_OF.items() if floor < FLOOR_OF["study"]}
    assert set(DECIDING) == below - NO_MATTER, FLOORS
    assert all(find_spec(f"hotlap.{package}") for package in DECIDING)
    assert len({digest_code("hotlap.analysis.comparison"), digest_code("hotlap.analysis.learning"), digest_code(__name__)}) == 3
