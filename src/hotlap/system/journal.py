"""Journal: results by key, one line of JSON each, written as soon as a result is there; readable after a kill at any moment."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

from hotlap.core.errors import StudyError
from hotlap.system.folder_lock import hold


class LinesFile:
    """A file of results by key, one line of JSON each, in a folder.

    Attributes:
        done: what is there so far.

    Raises:
        StudyError: the file cannot be read.
    """

    file = "lines.jsonl"

    def __init__(self, folder: Path) -> None:
        self.path = folder / self.file
        self.done: dict[Any, Any] = {}
        self._size = self._read()

    @classmethod
    @contextmanager
    def opened(cls, folder: Path) -> Iterator[Self]:
        """Hold a folder, made if there is none, to write.

        Raises:
            StudyError: it cannot be used, or another process holds it.
        """
        lock = hold(folder)
        try:
            lines = cls(folder)
            if lines.path.exists():
                os.truncate(lines.path, lines._size)
            yield lines
        finally:
            os.close(lock)

    def add(self, key: Any, value: Any) -> None:
        """Keep a result.

        Raises:
            StudyError: there is no room; what was kept before stays.
        """
        line = json.dumps(self._plain(key, value), allow_nan=False) + "\n"
        try:
            with self.path.open("ab") as file:
                file.write(line.encode())
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise StudyError(str(self.path), "", f"cannot be written ({error.strerror}); what was kept before stays") from None
        self.done[key] = value

    def _plain(self, key: Any, value: Any) -> Any:
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
                key, value = self._parsed(json.loads(line))
                self.done[key] = value
            except (ValueError, KeyError, TypeError, AttributeError):
                raise StudyError(str(self.path), f"line {number}", "is damaged; delete the line, and it is made again") from None
        return len(whole) + 1 if whole else 0
