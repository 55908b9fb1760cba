"""Records: studies and journals of hotlap's own, damaged as bytes, or in what they say with checksums that fit."""

from __future__ import annotations

import json
import os
import shutil
import sqlite3
import tempfile
import warnings
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

from fake_world import FakeWorld
from fuzz.mutation import ODD_VALUES, damage, disturb
from hotlap.analysis.comparison import Run, RunJournal
from hotlap.core.errors import StudyError
from hotlap.report.page.document import dump_study
from hotlap.study.database import APPLICATION, FILE
from hotlap.study.formats import COLUMNS, TABLES_OF, seal
from hotlap.study.glance import Follower, State
from hotlap.study.snapshot import read_snapshot
from hotlap.study.study import Study, count_flights
from hotlap.system.journal import Journal
from hotlap.tuning.objective import Objective
from studies import carry, configure

Read = Callable[[], Any]
LONG = 50_000_000  # rows of a view: more than a reader has time for


@dataclass(frozen=True)
class Record:
    """What hotlap writes and reads again.

    Attributes:
        name: of it.
        give: draws a damaged one in a folder, and gives what reads it.
    """

    name: str
    give: Callable[[Random, Path], Read]


@cache
def _asked() -> Any:
    return configure(budget=20, validation=5, goal="none")


@cache
def sample_study() -> bytes:
    """A small study that has ended."""
    with tempfile.TemporaryDirectory() as folder:
        carry(Path(folder), _asked(), FakeWorld(name="plausible"), command="hotlap tune straight")
        with Study.open(folder, _asked()) as study:
            study.keep_advice(["fly slower"])
        return (Path(folder) / FILE).read_bytes()


def damaged_bytes(random: Random, folder: Path) -> Read:
    """A study with bytes that were not written so."""
    (folder / FILE).write_bytes(damage(sample_study(), random))
    return lambda: use(folder)


def damaged_values(random: Random, folder: Path) -> Read:
    """A study with odd values, whose checksums fit, as no accident leaves it: it is read, neither shown nor continued."""
    (folder / FILE).write_bytes(sample_study())
    with closing(sqlite3.connect(folder / FILE)) as connection:
        for _ in range(random.choice((1, 1, 2))):
            _disturb_row(connection, random)
        seal(lambda statement, values=(): connection.execute(statement, values).fetchall())
        connection.commit()
    return lambda: use(folder, _read, count_flights)


def strange_tables(random: Random, folder: Path) -> Read:
    """A file of any format with what a stranger may have put in the place of its tables, or beside them; none of it ever runs."""
    (folder / FILE).unlink(missing_ok=True)
    made = random.choice(tuple(TABLES_OF))
    tables = dict(TABLES_OF[made])
    odd = random.choice(tuple(tables))
    names = COLUMNS[odd].split(", ")
    endless = f"WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n LIMIT {LONG}) SELECT"  # noqa: S608
    strange = {
        f"CREATE VIEW {odd} AS {endless} {', '.join(f'i AS {name}' for name in names)} FROM n": True,
        f"CREATE VIRTUAL TABLE {odd} USING fts5({', '.join(names)})": True,
        f"CREATE TABLE {odd} ({', '.join(names)}, more AS (hex(zeroblob(100000000))))": True,
        f"CREATE TABLE {odd} ({', '.join(names)}, CHECK (length(hex(zeroblob(100000000)))))": True,
        f"CREATE TRIGGER t BEFORE {random.choice(('INSERT', 'UPDATE', 'DELETE'))} ON {odd} BEGIN {endless} count(*) FROM n; END": False,
        f"CREATE INDEX t ON {odd} (hex(zeroblob(100000000)))": False,
        f"CREATE VIEW t AS {endless} i FROM n": False,
    }
    statement, instead = random.choice(list(strange.items()))
    if instead:
        del tables[odd]
    with closing(sqlite3.connect(folder / FILE)) as connection:
        for wanted in (*tables.values(), statement):
            connection.execute(wanted)
        connection.execute(f"PRAGMA application_id = {APPLICATION}")
        connection.execute(f"PRAGMA user_version = {made}")

    def read() -> None:
        use(folder, _read, count_flights, _continue)
        raise AssertionError(f"is taken for a study: {statement}")

    return read


def _disturb_row(connection: sqlite3.Connection, random: Random) -> None:
    """One value of one row, or the row itself."""
    table = random.choice(("entry", "entry", "entry", "increment", "opening", "flight"))
    place = "rowid" if table != "entry" else "key"
    rows = connection.execute(f"SELECT {place}, {COLUMNS[table]} FROM {table}").fetchall()  # noqa: S608  names of ours
    names = COLUMNS[table].split(", ")
    row, column = random.choice(rows), random.randrange(len(names))
    if random.random() < 0.1:
        connection.execute(f"DELETE FROM {table} WHERE {place} = ?", (row[0],))  # noqa: S608
        return
    value = row[1 + column]
    if _is_json(value) and random.random() < 0.8:
        value = json.dumps(disturb(json.loads(value), random), default=str)
    elif isinstance(value, str | bytes) and random.random() < 0.6:
        raw = damage(value if isinstance(value, bytes) else value.encode(), random)
        value = raw if isinstance(value, bytes) else raw.decode("utf-8", "replace")
    else:
        value = random.choice([odd for odd in ODD_VALUES if isinstance(odd, float | str | bytes | type(None)) or odd == 0])
    connection.execute(f"UPDATE OR IGNORE {table} SET {names[column]} = ? WHERE {place} = ?", (value, row[0]))  # noqa: S608


def _is_json(value: Any) -> bool:
    """Whether a value is the text of a list or a table, which the disturbance before may have changed."""
    if not isinstance(value, str) or value[:1] not in "[{":
        return False
    try:
        json.loads(value)
    except ValueError:
        return False
    return True


def use(folder: Path, *steps: Callable[[Path], Any]) -> None:
    """What is done with a study: looked at, shown, counted and continued. Raises the first refusal, after all has been tried."""
    refusals: list[StudyError] = []
    glance = Follower(folder, "one").look()
    assert glance.state is not State.UNREADABLE or (glance.fault and "\n" not in glance.fault)
    for step in steps or (_show, count_flights, _continue):
        try:
            step(folder)
        except StudyError as error:
            refusals.append(error)
    if refusals:
        raise refusals[0]


def _read(folder: Path) -> Any:
    with Study(folder) as study:
        study.records()
        return read_snapshot(study)


def _show(folder: Path) -> None:
    dump_study(_read(folder), None)


def _continue(folder: Path) -> None:
    asked = configure(budget=22, validation=5, goal="none")
    with Study.open(folder, asked) as study:
        study.run(Objective(asked.scenario, FakeWorld(name="plausible"), asked.metric))


RUN = Run("straight", "random", 0, 20, 20, 20, True, 1.0, 0.25, 5.0, 48, 50, 0.1, ((1, 0.5), (20, 1.0)))


@cache
def sample_journal(of_runs: bool) -> bytes:
    """Ten results."""
    with tempfile.TemporaryDirectory() as folder:
        kind = RunJournal if of_runs else Journal
        with kind.opened(Path(folder), "code") as journal:
            for seed in range(10):
                run = Run(**{**vars(RUN), "seed": seed})
                journal.add(("key", seed) if of_runs else f"piece {seed}", run if of_runs else {"flight": seed, "error": [0.1, None]})
        return journal.path.read_bytes()


def damaged_journal(kind: type[Journal]) -> Callable[[Random, Path], Read]:
    """A journal with bytes that were not written so: what is whole counts, and what is missing is written again."""
    of_runs = kind is RunJournal

    def give(random: Random, folder: Path) -> Read:
        before = sample_journal(of_runs)
        after = damage(before, random)
        shutil.rmtree(folder / "journal", ignore_errors=True)
        (folder / "journal").mkdir()
        (folder / "journal" / kind.file).write_bytes(after)
        done = before_of(kind)
        whole = {line for line in after.split(b"\n")[:-1] if line and line in before.split(b"\n")}

        def read() -> None:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # lines that are damaged are told
                kept = kind(folder / "journal", "code")
                assert all(done[key] == value for key, value in kept.done.items()), "nothing counts but what was written"
                assert len(kept.done) >= len(whole), "all that is whole counts"
                with kind.opened(folder / "journal", "code") as journal:
                    for key, value in done.items():
                        if key not in journal.done:
                            journal.add(key, value)
            assert kind(folder / "journal", "code").done == done  # without a warning

        return read

    return give


@cache
def before_of(kind: type[Journal]) -> dict[Any, Any]:
    """What a journal holds that is whole."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / kind.file).write_bytes(sample_journal(kind is RunJournal))
        return kind(Path(folder), "code").done


def odd_files(random: Random, folder: Path) -> Read:
    """Something else in the place of one of a study's files."""
    shutil.rmtree(folder / "odd", ignore_errors=True)
    place = folder / "odd"
    place.mkdir()
    (place / FILE).write_bytes(sample_study())
    path = place / random.choice((FILE, f"{FILE}-journal", f"{FILE}-wal", "study.lock"))
    path.unlink(missing_ok=True)
    how = random.randrange(6)
    if how == 0:
        os.mkfifo(path)
    elif how == 1:
        path.mkdir()
    elif how == 2:
        path.symlink_to("/dev/zero" if path.name != "study.lock" else "/dev/null")
    elif how == 3:
        path.symlink_to(path.name)
    elif how == 4:
        path.write_bytes(random.randbytes(random.choice((0, 1, 512, 5000))))
    else:
        path.symlink_to("nowhere" * 50)
    return lambda: use(place)


RECORDS: dict[str, Record] = {
    record.name: record
    for record in (
        Record("study.sqlite, bytes", damaged_bytes),
        Record("study.sqlite, values", damaged_values),
        Record("study.sqlite, strange tables", strange_tables),
        Record("study, odd files", odd_files),
        Record("runs.jsonl", damaged_journal(RunJournal)),
        Record("lines.jsonl", damaged_journal(Journal)),
    )
}
