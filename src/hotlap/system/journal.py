"""Journal: results by key, a line of JSON each, written when a result is there; whole after a kill at any moment."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

from hotlap.core.errors import StudyError
from hotlap.system.folder_lock import hold


class Journal:
    """Results by key, in `file` of a folder.

    Args:
        folder: of the file.
        code: digest of the source code that computes the results; None: results count whatever code has computed them.

    Attributes:
        done: results so far that count.
        stale: keys of results that do not count, as other code has computed them.

    Raises:
        StudyError: the file cannot be read.
    """

    file = "lines.jsonl"

    def __init__(self, folder: Path, code: str | None = None) -> None:
        self.path = folder / self.file
        self.done: dict[Any, Any] = {}
        self.stale: set[Any] = set()
        self._code = code
        self._size = self._read()
        self.stale -= self.done.keys()

    @classmethod
    @contextmanager
    def opened(cls, folder: Path, code: str | None = None) -> Iterator[Self]:
        """Open a folder to write, made if there is none, and lock it against other processes.

        Args:
            folder: of the file.
            code: digest of the source code that computes the results; None: results count whatever code has computed them.

        Raises:
            StudyError: it cannot be used, or another process holds it.
        """
        lock = hold(folder)
        try:
            journal = cls(folder, code)
            if journal.path.exists():
                os.truncate(journal.path, journal._size)
            yield journal
        finally:
            os.close(lock)

    def add(self, key: Any, value: Any) -> None:
        """Keep a result.

        Raises:
            StudyError: there is no room; what was kept before stays.
        """
        code = {} if self._code is None else {"code": self._code}
        line, new = json.dumps({**self._plain(key, value), **code}, allow_nan=False) + "\n", not self.path.exists()
        try:
            with self.path.open("ab") as file:
                file.write(line.encode())
                file.flush()
                os.fsync(file.fileno())
            if new:
                _sync(self.path.parent)
        except OSError as error:
            raise StudyError(str(self.path), "", f"cannot be written ({error.strerror}); what was kept before stays") from None
        self.done[key] = value
        self.stale.discard(key)

    def _plain(self, key: Any, value: Any) -> dict[str, Any]:
        """A line's content."""
        return {"key": key, "value": value}

    def _parsed(self, plain: Any) -> tuple[Any, Any]:
        """The inverse of `_plain`."""
        return plain["key"], plain["value"]

    def _read(self) -> int:
        """Read what there is; the size of its whole lines: what is behind them was being written when the power went."""
        try:
            whole = self.path.read_bytes().rpartition(b"\n")[0]
        except FileNotFoundError:
            return 0
        except OSError as error:
            raise StudyError(str(self.path), "", f"cannot be read: {error.strerror}") from None
        for number, line in enumerate(whole.splitlines(), 1):
            try:
                plain = json.loads(line)
                key, value = self._parsed(plain)
                if self._code in {None, plain.get("code")}:
                    self.done[key] = value
                else:
                    self.stale.add(key)
            except (ValueError, KeyError, TypeError, AttributeError):
                raise StudyError(str(self.path), f"line {number}", "is damaged; delete the line, and it is made again") from None
        return len(whole) + 1 if whole else 0


def _sync(folder: Path) -> None:
    """Keep the names of a folder's files through a power cut."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
