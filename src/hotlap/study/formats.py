"""Formats: the tables of a study, and the way from those of earlier versions to the present ones, a step for each.

1   the state of a run as one entry, written whole at every batch
2   the same tables; configurations tell more apart
3   the state as increments, a row a batch
4   a checksum in every row
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from hotlap.core.printable import printable
from hotlap.study.checksums import checksum
from hotlap.study.increments import VALUE

FORMAT = 4
TABLES: Mapping[str, str] = {
    "entry": "CREATE TABLE entry (key TEXT PRIMARY KEY, value, digest INTEGER) WITHOUT ROWID",
    "opening": "CREATE TABLE opening (time TEXT, versions TEXT, digest INTEGER)",
    "increment": "CREATE TABLE increment (change TEXT, digest INTEGER)",
    "flight": "CREATE TABLE flight (stream TEXT, number INTEGER, seed INTEGER, parameters BLOB, cost REAL, completion REAL,"
    " failed_segment INTEGER, mean_error REAL, max_error REAL, lap_time REAL, accepted INTEGER, digest INTEGER,"
    " PRIMARY KEY (stream, number))",
}
COLUMNS: Mapping[str, str] = {
    "entry": "key, value",
    "opening": "time, versions",
    "increment": "change",
    "flight": "stream, number, seed, parameters, cost, completion, failed_segment, mean_error, max_error, lap_time, accepted",
}
"""Of each table, without the checksum over them."""
CHAINED = ("opening", "increment")  # tables whose checksums go on from the row before
_FIRST: Mapping[str, str] = {
    "entry": "CREATE TABLE entry (key TEXT PRIMARY KEY, value) WITHOUT ROWID",
    "opening": "CREATE TABLE opening (time TEXT, versions TEXT)",
    "flight": TABLES["flight"].replace(" digest INTEGER,", ""),
}
TABLES_OF: Mapping[int, Mapping[str, str]] = {
    1: _FIRST,
    2: _FIRST,
    3: {**_FIRST, "increment": "CREATE TABLE increment (change TEXT)"},
    FORMAT: TABLES,
}
"""Of each format, as `sqlite_master` has them."""

Execute = Callable[..., list[tuple[Any, ...]]]
"""Runs a statement with values; gives its rows."""


def create(execute: Execute) -> None:
    """Make the tables of a new study."""
    for statement in TABLES.values():
        execute(statement)


def fault_of(execute: Execute, made: int = FORMAT) -> str:
    """What is wrong with the tables of a study; "" where nothing is.

    To be asked before anything else: a view, a trigger, a check or a computed column that someone has put there runs when a table is read,
    written or checked, and may never end.

    Args:
        execute: runs a statement.
        made: the format, from 1 to `FORMAT`.
    """
    tables, seen = TABLES_OF[made], set[str]()
    for kind, name, table, sql in execute("SELECT type, name, tbl_name, sql FROM sqlite_master"):
        if kind == "index" and sql is None and table in tables:  # of its primary key
            continue
        if name not in tables:
            return f"it has {printable(str(name))}, which no study has"
        if name in seen or (kind, table, _plain(str(sql))) != ("table", name, tables[name]):
            return f"its table {name} is not as it was made"
        seen.add(name)
    lost = next((name for name in tables if name not in seen), None)
    return "" if lost is None else f"its table {lost} is not as it was made"


def migrate(execute: Execute, made: int) -> None:
    """Turn the tables of an earlier format into the present ones; within a transaction.

    Args:
        execute: runs a statement.
        made: the format, 1 or later.
    """
    for step in STEPS[made - 1 :]:
        step(execute)


def seal(execute: Execute) -> None:
    """Write the checksums of all rows anew."""
    for table, columns in COLUMNS.items():
        place = "key" if table == "entry" else "rowid"
        before = 0
        for row in execute(f"SELECT {place}, {columns} FROM {table} ORDER BY {place}"):  # noqa: S608  names of ours
            before = checksum(row[1:], before if table in CHAINED else 0)
            execute(f"UPDATE {table} SET digest = ? WHERE {place} = ?", (before, row[0]))  # noqa: S608


def _tell_more_apart(_: Execute) -> None:
    """From 1 to 2: no table has changed."""


def _keep_increments(execute: Execute) -> None:
    """From 2 to 3."""
    execute(TABLES_OF[3]["increment"])
    for (state,) in execute("SELECT value FROM entry WHERE key = 'state'"):
        execute("INSERT INTO increment VALUES (?)", (json.dumps({VALUE: json.loads(state)}),))
    execute("DELETE FROM entry WHERE key = 'state'")


def _keep_checksums(execute: Execute) -> None:
    """From 3 to 4: new tables, as a column that is added would stand in them otherwise than in a new study."""
    for table, columns in COLUMNS.items():
        order = "key" if table == "entry" else "rowid"
        execute(f"ALTER TABLE {table} RENAME TO former")
        execute(TABLES[table])
        execute(f"INSERT INTO {table} ({columns}) SELECT {columns} FROM former ORDER BY {order}")  # noqa: S608  names of ours
        execute("DROP TABLE former")
    seal(execute)


STEPS: tuple[Callable[[Execute], None], ...] = (_tell_more_apart, _keep_increments, _keep_checksums)


def _plain(sql: str) -> str:
    """A statement without line breaks."""
    return re.sub(r"\s+", " ", sql).strip()


def verified(rows: Iterable[tuple[Any, ...]], before: int | None = None) -> Iterable[tuple[Any, ...]]:
    """Rows without their checksums.

    Args:
        rows: values, and behind them the checksum.
        before: that of the row before, in a chain; None: each row stands for itself.

    Raises:
        ValueError: a row is not what was written.
    """
    for *values, digest in rows:
        found = checksum(values, before or 0)
        if found != digest:
            raise ValueError("a row is not as it was written")
        before = None if before is None else found
        yield tuple(values)
