"""A study at a glance says what the study says, at every moment, and reads no more of it than is new."""

from __future__ import annotations

import json
import math
import os
import shutil
import sqlite3
from contextlib import closing

import pytest

from fake_world import FakeWorld
from hotlap.study.database import FILE, Database
from hotlap.study.glance import DEEPEST, Follower, State, find_studies
from hotlap.study.study import Study
from hotlap.system.folder_lock import LOCK
from hotlap.tuning.objective import Objective
from plausible_world import PlausibleWorld
from studies import begin, carry, configure


def test_a_finished_study_is_what_it_says_of_itself(tmp_path):
    snapshot = carry(tmp_path / "s", configure(budget=60))
    result, glance = snapshot.result, Follower(tmp_path / "s", "s").look()
    assert result is not None
    assert result.validation is not None
    asked = snapshot.configuration
    assert (glance.race, glance.tuner, glance.goal, glance.seed) == (result.race, result.tuner, result.goal, result.seed)
    assert (glance.world, glance.budget, glance.flights) == (asked.world, 60, result.flights)
    assert (glance.completion, glance.successes, glance.validation) == (
        result.best.completion,
        result.validation.successes,
        result.validation.flights,
    )
    assert glance.state is (State.CONFIRMED if result.best.confirmed else State.NOT_SOLVED)
    assert glance.lap_time == pytest.approx(result.best.lap_time, nan_ok=True)


@pytest.mark.parametrize("goal", ["none", "completion=1"])
def test_it_follows_a_search_batch_by_batch(tmp_path, goal):
    asked, seen = configure(goal=goal, budget=40, validation=5), []
    with Study.open(tmp_path / "s", asked) as study:
        follower = Follower(tmp_path / "s", "s")
        assert follower.look().flights == 0
        assert math.isnan(follower.look().completion)

        def watch(batch):
            glance = follower.look()
            seen.append(glance.state)
            assert (glance.flights, glance.completion) == (batch.flights, batch.best.completion)
            assert (glance.state in {State.CONFIRMED, State.NOT_SOLVED, State.FINISHED}) == batch.done

        study.run(Objective(asked.scenario, PlausibleWorld(), asked.metric), watch)
    assert seen[0] is State.SEARCHING
    assert (seen[-1] is State.FINISHED) == (goal == "none")


def test_what_has_not_changed_is_not_opened_and_what_has_is_read_from_there_on(tmp_path, monkeypatch):
    asked = configure(goal="none", budget=40, validation=0)
    statements: list[tuple[str, tuple]] = []
    run = Database.execute

    def execute(self, statement, values=()):
        statements.append((statement, tuple(values)))
        return run(self, statement, values)

    with Study.open(tmp_path / "s", asked) as study:
        follower = Follower(tmp_path / "s", "s")
        first = follower.look()
        monkeypatch.setattr(Database, "execute", execute)
        assert follower.look() is first
        assert statements == []
        monkeypatch.setattr(Database, "execute", run)
        study.run(Objective(asked.scenario, FakeWorld(name="plausible"), asked.metric))
        half = follower.look()
        monkeypatch.setattr(Database, "execute", execute)
        study.keep_command("again")
        assert follower.look() == half.__class__(**{**vars(half), "changed": follower.look().changed})
    rows = [values for statement, values in statements if "FROM increment WHERE" in statement]
    assert rows
    assert all(first > 0 for (first,) in rows)


def test_a_study_whose_process_is_gone_has_stopped(tmp_path):
    begin(tmp_path / "s", configure())
    follower = Follower(tmp_path / "s", "s")
    assert follower.look().state is State.SEARCHING, "this process began it"
    ended = os.fork()
    if not ended:
        os._exit(0)
    os.waitpid(ended, 0)
    (tmp_path / "s" / LOCK).write_text(f"{ended}\n")
    assert follower.look().state is State.STOPPED
    (tmp_path / "s" / LOCK).unlink()
    assert follower.look().state is State.STOPPED


@pytest.mark.parametrize("content", [b"", b"no database" * 99, b"SQLite format 3\x00"])
def test_what_is_no_study_is_unreadable_and_says_why(tmp_path, content):
    (tmp_path / FILE).write_bytes(content)
    glance = Follower(tmp_path, "s").look()
    assert glance.state is State.UNREADABLE
    assert len(glance.fault) > 10


def test_a_study_of_another_format_or_without_what_it_needs_is_unreadable(tmp_path):
    begin(tmp_path / "s", configure())
    for change in ("DELETE FROM entry WHERE key = 'configuration'", "PRAGMA user_version = 99"):
        with closing(sqlite3.connect(tmp_path / "s" / FILE, isolation_level=None)) as connection:
            connection.execute(change)
        assert Follower(tmp_path / "s", "s").look().state is State.UNREADABLE
    assert Follower(tmp_path / "s", "s").look().fault.startswith("was made by a newer hotlap")
    follower = Follower(tmp_path / "s", "s")
    shutil.rmtree(tmp_path / "s")
    assert follower.look().fault == f"{FILE}: No such file or directory"


def test_a_larger_budget_is_seen_and_the_search_goes_on(tmp_path):
    carry(tmp_path / "s", configure(goal="none", budget=20, validation=0))
    follower = Follower(tmp_path / "s", "s")
    assert follower.look().state is State.FINISHED
    with Study.open(tmp_path / "s", configure(goal="none", budget=40, validation=0)):
        glance = follower.look()
    assert (glance.state, glance.budget) == (State.SEARCHING, 40)


def test_studies_are_found_below_a_folder_but_not_too_deep_and_not_within_each_other(tmp_path):
    names = ["b", "a/x", "a/y/z", "a/x/inner", "/".join("d" * (DEEPEST + 1))]
    for name in names:
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / FILE).touch()
    assert [path.relative_to(tmp_path).as_posix() for path in find_studies(tmp_path)] == ["a/x", "a/y/z", "b"]
    assert list(find_studies(tmp_path / "nowhere")) == []


def test_states_are_plain_words():
    assert json.dumps([State.NOT_SOLVED]) == '["not solved"]'
