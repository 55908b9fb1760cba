"""Database: the SQLite file of a study: who may write it, and its errors as one clear line."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hotlap.core.errors import StudyError
from hotlap.system.folder_lock import hold

FILE = "study.sqlite"
APPLICATION = 0x686F746C  # "hotl", in the header of the file
FORMAT = 3  # of the tables and of what is kept in them; any other is refused

_WORDS = {
    sqlite3.SQLITE_FULL: "the disk is full; all batches so far are kept: make room, and the same command goes on from there",
    sqlite3.SQLITE_IOERR: "the disk refuses to read or write; all batches so far are kept, and the same command goes on from there",
    sqlite3.SQLITE_NOTADB: f"{FILE} is no database, so no study",
    sqlite3.SQLITE_CORRUPT: f"{FILE} is damaged",
    sqlite3.SQLITE_CANTOPEN: f"{FILE} cannot be opened",
    sqlite3.SQLITE_READONLY: f"{FILE} cannot be written",
    sqlite3.SQLITE_BUSY: f"{FILE} is in use by another program",
}


def is_begun(folder: Path) -> bool:
    """Whether a folder holds a study; a file that was made and never filled, since its maker was stopped, is none.

    Raises:
        StudyError: what it holds cannot be read, or is no study.
    """
    if not (folder / FILE).exists() or (folder / FILE).stat().st_size == 0:
        return False
    database = Database(folder, owned=False)
    try:
        return not database.is_new()
    finally:
        database.close()


class Database:
    """An open file, with SQLite's default journal: whole up to the last transaction after a kill or a power cut.

    Args:
        folder: of the file.
        owned: open it to write, made if there is none, and lock it against other processes until `close`; else open it to read,
            also while another process writes.

    Raises:
        StudyError: the folder cannot be used, another process has locked it, or the file cannot be opened.
    """

    def __init__(self, folder: Path, *, owned: bool) -> None:
        self.folder = folder
        self._lock = hold(folder) if owned else None
        mode = "rwc" if owned else "rw"  # to read after a kill is to roll back first
        try:
            with self.readable_errors():
                location = f"{(folder / FILE).absolute().as_uri()}?mode={mode}"
                self._connection = sqlite3.connect(location, uri=True, isolation_level=None, timeout=30.0)
                self._connection.execute("PRAGMA synchronous = EXTRA")  # FULL lets a power cut take the last transaction back
        except BaseException:
            self._release()
            raise

    def __del__(self) -> None:
        if hasattr(self, "_connection"):
            self.close()

    def close(self) -> None:
        """Close the file and unlock the folder; everything is written already."""
        self._connection.close()
        self._release()

    def is_new(self) -> bool:
        """Whether the file is empty.

        Raises:
            StudyError: it is no study, damaged, or of a newer format.
        """
        application, made = self._pragma("application_id"), self._pragma("user_version")
        if application == 0 and self._pragma("page_count") == 0:
            return True
        if application != APPLICATION:
            raise StudyError(str(self.folder), "", f"{FILE} is a database, but no study")
        if made != FORMAT:
            maker = "a newer hotlap" if made > FORMAT else "an older hotlap"
            raise StudyError(str(self.folder), "", f"was made by {maker} (format {made}; this one reads {FORMAT})")
        if self._pragma("quick_check") != "ok":
            raise StudyError(str(self.folder), "", f"{FILE} is damaged")
        return False

    def create(self, schema: str) -> None:
        """Make the tables of a new file; within a transaction."""
        for statement in schema.split(";"):
            self.execute(statement)
        self.execute(f"PRAGMA application_id = {APPLICATION}")
        self.execute(f"PRAGMA user_version = {FORMAT}")

    def execute(self, statement: str, values: Iterable[Any] = ()) -> list[tuple[Any, ...]]:
        """Run one statement; returns its rows."""
        with self.readable_errors():
            return self._connection.execute(statement, tuple(values)).fetchall()

    def insert(self, statement: str, rows: Iterable[tuple[Any, ...]]) -> None:
        """Run one statement for many rows of values."""
        with self.readable_errors():
            self._connection.executemany(statement, rows)

    @contextmanager
    def transaction(self) -> Iterator[None]:
        """A context within which all statements are kept, or none of them."""
        self.execute("BEGIN IMMEDIATE")
        try:
            yield
            self.execute("COMMIT")
        except BaseException:
            if self._connection.in_transaction:
                self.execute("ROLLBACK")
            raise

    @contextmanager
    def at_one_moment(self) -> Iterator[None]:
        """A context within which all that is read is of one moment; writers wait."""
        self.execute("BEGIN")
        try:
            yield
        finally:
            if self._connection.in_transaction:
                self.execute("ROLLBACK")

    @contextmanager
    def readable_errors(self) -> Iterator[None]:
        """A context that turns an error of SQLite into a `StudyError` of one line; those of wrong statements pass unchanged."""
        try:
            yield
        except (sqlite3.IntegrityError, sqlite3.ProgrammingError):
            raise
        except sqlite3.DatabaseError as error:
            primary = getattr(error, "sqlite_errorcode", 0) & 0xFF
            raise StudyError(str(self.folder), "", _WORDS.get(primary, f"{FILE} cannot be used: {error}")) from None

    def _pragma(self, name: str) -> Any:
        return self.execute(f"PRAGMA {name}")[0][0]

    def _release(self) -> None:
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None
