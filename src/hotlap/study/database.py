"""Database: the SQLite file of a study: who may write it, and its errors as one clear line."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from hotlap.core.errors import StorageError, StudyError
from hotlap.core.printable import printable
from hotlap.study import formats
from hotlap.study.formats import FORMAT
from hotlap.system.folder_lock import hold
from hotlap.system.regular_files import oddity
from hotlap.system.text_files import cause_of

FILE = "study.sqlite"
APPLICATION = 0x686F746C  # "hotl", in the header of the file
BESIDE = ("", "-journal", "-wal", "-shm")  # of the file's name: what SQLite opens
LONGEST_PATH = 480  # bytes; SQLite takes 512, with what it appends to the name
STORAGE = (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR)  # at fault is the disk, and nothing that was given

_WORDS = {
    sqlite3.SQLITE_FULL: "the disk is full; all batches so far are kept: make room, and the same command goes on from there",
    sqlite3.SQLITE_IOERR: "the disk refuses to read or write; all batches so far are kept, and the same command goes on from there",
    sqlite3.SQLITE_NOTADB: f"{FILE} is no database, so no study",
    sqlite3.SQLITE_CORRUPT: f"{FILE} is damaged: its pages do not fit together",
    sqlite3.SQLITE_CANTOPEN: f"{FILE} cannot be opened",
    sqlite3.SQLITE_READONLY: f"{FILE} cannot be written",
    sqlite3.SQLITE_BUSY: f"{FILE} is in use by another program",
}


def is_begun(folder: Path) -> bool:
    """Whether a folder holds a study; a file that was made and never filled, since its maker was stopped, is none.

    Raises:
        StudyError: what it holds cannot be read, or is no study.
    """
    try:
        if (folder / FILE).stat().st_size == 0:
            return False
    except (FileNotFoundError, NotADirectoryError):
        return False
    except (OSError, ValueError) as error:
        raise _unusable(folder, error) from None
    database = Database(folder, owned=False)
    try:
        return not database.is_new()
    finally:
        database.close()


def _unusable(folder: Path, error: Exception) -> StudyError:
    """The error that says why a path is not that of a study."""
    return StudyError(str(folder), "", f"cannot be used as the folder of a study: {cause_of(error)}")


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
        self._refuse_odd_files()
        self._lock = hold(folder) if owned else None
        mode = "rwc" if owned else "rw"  # to read after a kill is to roll back first
        try:
            with self.readable_errors():
                location = f"{(folder / FILE).absolute().as_uri()}?mode={mode}"
                self._connection = sqlite3.connect(location, uri=True, isolation_level=None, timeout=30.0)
                self._connection.execute("PRAGMA synchronous = EXTRA")  # FULL lets a power cut take the last transaction back
                self._connection.execute("PRAGMA fullfsync = ON")  # as `drive.flush`; of macOS alone
                self._connection.execute("PRAGMA trusted_schema = OFF")
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

    def is_new(self, *, checked: bool = True) -> bool:
        """Whether the file is empty. One of an earlier format is migrated: the file itself where it is owned, else a copy of it.

        Args:
            checked: look at all of a file that is not, whether it is damaged.

        Raises:
            StudyError: it is no study, damaged, or of a newer format.
        """
        made = self.format()
        if made == 0:
            return True
        if made < FORMAT and self._lock is None:
            self._read_a_copy()
            made = self.format()
        if checked and self._pragma("quick_check") != "ok":
            raise self.damaged("its pages do not fit together")
        if made < FORMAT:
            self._migrate(made)
        return False

    def format(self) -> int:
        """Which format the file has, 0 where it is empty; nothing in it but its list of tables is looked at.

        Raises:
            StudyError: it is no study, of a newer format, or its tables are not those of its format.
        """
        application, made = self._pragma("application_id"), self._pragma("user_version")
        if application == 0 and self._pragma("page_count") == 0:
            return 0
        if application != APPLICATION:
            raise StudyError(str(self.folder), "", f"{FILE} is a database, but no study")
        if made > FORMAT:
            reason = f"was made by a newer hotlap (format {made}; this one reads up to {FORMAT}): update hotlap, or give another folder"
            raise StudyError(str(self.folder), "", reason)
        if made < 1:
            raise self.damaged(f"there is no format {made}")
        fault = formats.fault_of(self.execute, made)
        if fault:
            raise self.damaged(fault)
        return made

    def create(self) -> None:
        """Make the tables of a new file; within a transaction."""
        formats.create(self.execute)
        self.execute(f"PRAGMA application_id = {APPLICATION}")
        self.execute(f"PRAGMA user_version = {FORMAT}")

    def damaged(self, reason: str) -> StudyError:
        """The error that says what is damaged, and what is there beside it."""
        saved = [name for name in ("parameters.toml", "report.html") if (self.folder / name).is_file()]
        beside = f"; what it had found is in {' and '.join(saved)} beside it" if saved else ""
        return StudyError(str(self.folder), "", f"{FILE} is damaged: {reason}{beside}")

    @contextmanager
    def decoding(self, what: str) -> Iterator[None]:
        """A context in which something that is recorded is read: whatever fails there, the file is damaged.

        Args:
            what: is read.

        Raises:
            StudyError: in place of any other error.
        """
        try:
            yield
        except (StudyError, sqlite3.ProgrammingError):  # said already, or closed
            raise
        except Exception as error:
            raise self.damaged(f"{what} cannot be read back") from error

    def execute(self, statement: str, values: Iterable[Any] = ()) -> list[tuple[Any, ...]]:
        """Run one statement; returns its rows."""
        with self.readable_errors():
            return self._connection.execute(statement, tuple(values)).fetchall()

    def rows(
        self, table: str, *, where: str = "", values: Iterable[Any] = (), order: str = "rowid", before: int = 0
    ) -> list[tuple[Any, ...]]:
        """Rows of a table that are what was written, without their checksums.

        Args:
            table: in `formats.TABLES`.
            where: condition of the statement; "" for all.
            values: of the condition.
            order: of the rows.
            before: checksum of the row before the first, where the table has a chain of them.
        """
        condition = f"WHERE {where}" if where else ""
        found = self.execute(f"SELECT {formats.COLUMNS[table]}, digest FROM {table} {condition} ORDER BY {order}", values)  # noqa: S608
        try:
            return list(formats.verified(found, before if table in formats.CHAINED else None))
        except (ValueError, TypeError) as error:
            raise self.damaged(f"what was recorded as {table} has changed since") from error

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
        except sqlite3.ProgrammingError:
            raise
        except sqlite3.DatabaseError as error:
            primary = getattr(error, "sqlite_errorcode", 0) & 0xFF
            if primary not in _WORDS:
                raise self.damaged(printable(str(error))) from error
            kind = StorageError if primary in STORAGE else StudyError
            raise kind(str(self.folder), "", _WORDS[primary]) from None
        except (MemoryError, OverflowError, UnicodeError) as error:
            raise self.damaged("its pages do not fit together") from error

    def _pragma(self, name: str) -> Any:
        return self.execute(f"PRAGMA {name}")[0][0]

    def _read_a_copy(self) -> None:
        """Go on with a copy in memory, which may be changed."""
        copy = sqlite3.connect(":memory:", isolation_level=None)
        copy.execute("PRAGMA trusted_schema = OFF")
        with self.readable_errors(), closing(self._connection) as file:
            file.backup(copy)
        self._connection = copy

    def _migrate(self, made: int) -> None:
        """Turn an earlier format into the present one."""
        with self.decoding(f"format {made}"), self.transaction():
            formats.migrate(self.execute, made)
            self.execute(f"PRAGMA user_version = {FORMAT}")

    def _refuse_odd_files(self) -> None:
        """Refuse what SQLite cannot name, would wait for, or would write to as if it were a file."""
        try:
            size = len(os.fsencode((self.folder / FILE).absolute()))
        except (OSError, ValueError) as error:  # a working folder that is gone, a name that the system cannot have
            raise _unusable(self.folder, error) from None
        if size > LONGEST_PATH:
            raise StudyError(str(self.folder), "", f"its path is too long for SQLite: {size} bytes, of {LONGEST_PATH}")
        for path in (self.folder / f"{FILE}{ending}" for ending in BESIDE):
            try:
                odd = oddity(path)
            except (OSError, ValueError) as error:
                raise _unusable(self.folder, error) from None
            if odd:
                raise StudyError(str(self.folder), "", f"{path.name} is damaged: it {odd.partition(':')[0]}")

    def _release(self) -> None:
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None
