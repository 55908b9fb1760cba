"""Studies of earlier formats are migrated, those of later ones refused."""

from __future__ import annotations

import json
import shutil
import sqlite3
from contextlib import closing
from functools import reduce

import pytest

from fake_world import FakeWorld
from hotlap.core.errors import StudyError
from hotlap.study.database import FILE, is_begun
from hotlap.study.formats import COLUMNS, FORMAT, TABLES_OF
from hotlap.study.glance import Follower, State
from hotlap.study.increments import grow
from hotlap.study.snapshot import read_snapshot
from hotlap.study.study import Study, count_flights
from hotlap.tuning.objective import Objective
from studies import carry, configure

FORMER = {  # the tables as each format made them
    1: ("entry (key TEXT PRIMARY KEY, value) WITHOUT ROWID", "opening (time TEXT, versions TEXT)"),
    2: ("entry (key TEXT PRIMARY KEY, value) WITHOUT ROWID", "opening (time TEXT, versions TEXT)"),
    3: ("entry (key TEXT PRIMARY KEY, value) WITHOUT ROWID", "opening (time TEXT, versions TEXT)", "increment (change TEXT)"),
}
FLIGHT = """flight (stream TEXT, number INTEGER, seed INTEGER, parameters BLOB, cost REAL, completion REAL, failed_segment INTEGER,
    mean_error REAL, max_error REAL, lap_time REAL, accepted INTEGER, PRIMARY KEY (stream, number))"""


def as_of(made: int, now, folder):
    """The same study as an earlier version wrote it."""
    folder.mkdir()
    with closing(sqlite3.connect(folder / FILE)) as connection:
        connection.execute("ATTACH ? AS now", (str(now / FILE),))
        for table in (*FORMER[made], FLIGHT):
            connection.execute(f"CREATE TABLE {table}")
            name = table.split()[0]
            connection.execute(f"INSERT INTO main.{name} SELECT {COLUMNS[name]} FROM now.{name}")  # noqa: S608
        if made < 3:
            changes = [json.loads(change) for (change,) in connection.execute("SELECT change FROM now.increment ORDER BY rowid")]
            connection.execute("INSERT INTO entry VALUES ('state', ?)", (json.dumps(reduce(grow, changes, None)),))
        connection.execute("PRAGMA application_id = 1752134764")
        connection.execute(f"PRAGMA user_version = {made}")
        connection.commit()
    return folder


@pytest.mark.parametrize("made", FORMER)
def test_a_study_of_an_earlier_format_is_read_as_it_is_and_continued_as_if_it_were_of_this_one(tmp_path, made):
    asked = configure(goal="none", budget=20, validation=5)
    before = carry(tmp_path / "now", asked, FakeWorld(name="plausible"))
    old = as_of(made, tmp_path / "now", tmp_path / "old")
    content = (old / FILE).read_bytes()
    with Study(old) as study:
        read = read_snapshot(study)
    assert Follower(old, "old").look().state is State.FINISHED
    assert (old / FILE).read_bytes() == content, "to look at a study changes nothing"
    assert read.result.dump() == before.result.dump()
    more = configure(goal="none", budget=30, validation=5)
    for folder in (old, tmp_path / "now"):
        with Study.open(folder, more) as study:
            study.run(Objective(more.scenario, FakeWorld(name="plausible"), more.metric))
            assert study._database._pragma("user_version") == FORMAT
    ledgers = [Study(folder).flights() for folder in (old, tmp_path / "now")]
    assert ledgers[0].cost.tobytes() == ledgers[1].cost.tobytes()
    assert ledgers[0].parameters.tobytes() == ledgers[1].parameters.tobytes()


def test_a_study_of_a_later_format_is_refused_in_one_line(tmp_path):
    carry(tmp_path / "now", configure(), FakeWorld(name="plausible"))
    with closing(sqlite3.connect(tmp_path / "now" / FILE)) as connection:
        connection.execute(f"PRAGMA user_version = {FORMAT + 1}")
    with pytest.raises(StudyError, match=rf"was made by a newer hotlap .format {FORMAT + 1}; this one reads up to {FORMAT}.: update"):
        Study(tmp_path / "now")


def test_a_study_that_other_source_code_began_says_so_when_it_goes_on(tmp_path, monkeypatch):
    carry(tmp_path / "s", configure(goal="none", budget=20, validation=0), FakeWorld(name="plausible"))
    for module in ("study", "versions"):
        monkeypatch.setattr(f"hotlap.study.{module}.digest_of_flights", lambda: "another")
    asked = configure(goal="none", budget=30, validation=0)
    with pytest.warns(UserWarning, match="some of its flights are of other source code than this"):
        snapshot = carry(tmp_path / "s", asked, FakeWorld(name="plausible"))
    assert "Flown by several versions" in snapshot.remark
    shutil.rmtree(tmp_path / "s")


LONG = "WITH RECURSIVE more(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM more LIMIT 3000000) SELECT"
STRANGE = {  # what a stranger may put into a file, and what is said of it
    "a view": ("flight", f"CREATE VIEW flight AS {LONG} n AS stream FROM more", "table flight is not as it was made"),
    "a view of all that was asked for": (
        "entry",
        f"CREATE VIEW entry AS {LONG} 'state' AS key, n AS value FROM more",
        "table entry is not",
    ),
    "a trigger": (
        "",
        "CREATE TRIGGER more DELETE ON entry BEGIN INSERT INTO opening (time) VALUES (1); END",
        "it has more, which no study has",
    ),
    "a virtual table": ("opening", "CREATE VIRTUAL TABLE opening USING fts5(time, versions)", "it has|table opening is not"),
    "a check": ("opening", "CREATE TABLE opening (time TEXT, versions TEXT CHECK (hex(zeroblob(9))))", "table opening is not"),
    "an index": ("", "CREATE INDEX more ON flight (hex(seed))", "it has more, which no study has"),
    "a table": ("", "CREATE TABLE more (time)", "it has more, which no study has"),
    "a table less": ("flight", "SELECT 1", "table flight is not"),
}


@pytest.mark.parametrize("strange", STRANGE)
@pytest.mark.parametrize("made", TABLES_OF)
def test_tables_that_are_not_those_of_their_format_are_refused_before_anything_is_read(tmp_path, made, strange):
    table, statement, said = STRANGE[strange]
    with closing(sqlite3.connect(tmp_path / FILE)) as connection:
        for name, wanted in TABLES_OF[made].items():
            if name != table:
                connection.execute(wanted)
        connection.execute(statement)
        connection.execute("PRAGMA application_id = 1752134764")
        connection.execute(f"PRAGMA user_version = {made}")
    content = (tmp_path / FILE).read_bytes()
    for read in (Study, is_begun, count_flights, lambda folder: Study.open(folder, configure())):
        with pytest.raises(StudyError, match=f"is damaged: .*{said}"):
            read(tmp_path)
    assert Follower(tmp_path, "strange").look().state is State.UNREADABLE
    assert (tmp_path / FILE).read_bytes() == content


def test_of_two_tables_of_one_name_neither_counts(tmp_path):
    carry(tmp_path / "now", configure(), FakeWorld(name="plausible"))
    with closing(sqlite3.connect(tmp_path / "now" / FILE)) as connection:
        connection.execute("PRAGMA writable_schema = ON")
        trigger = "CREATE TRIGGER entry DELETE ON opening BEGIN SELECT 1; END"
        connection.execute("INSERT INTO sqlite_master VALUES ('trigger', 'entry', 'opening', 0, ?)", (trigger,))
        connection.commit()
    with pytest.raises(StudyError, match="is damaged: its table entry is not as it was made"):
        Study(tmp_path / "now")
