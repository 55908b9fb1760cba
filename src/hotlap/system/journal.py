"""Journal: results by key, a line of JSON each, written when a result is there; whole after a kill at any moment.

Every line ends with a checksum of what stands before it. Lines that are not as they were written are left out with a warning, and made
again by whoever continues; what is whole stays.
"""

from __future__ import annotations

import json
import os
import re
import warnings
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

from hotlap.core.errors import InputError, StorageError, StudyError
from hotlap.system.drive import flush
from hotlap.system.folder_lock import hold
from hotlap.system.regular_files import MISSING, read_bytes
from hotlap.system.whole_files import STORAGE, sync, written_whole

DAMAGED = ".damaged"  # behind the name of the file in which damaged lines are kept
MOST_BYTES = 2_000_000_000
_SEALED = re.compile(rb'(?P<content>\{.*), "checksum": (?P<checksum>\d+)\}')


class Journal:
    """Results by key, in `file` of a folder.

    Args:
        folder: of the file.
        code: digest of the source code that computes the results; None: results count whatever code has computed them.

    Attributes:
        done: results so far that count.
        stale: keys of results that do not count, as other code has computed them.
        damaged: numbers of the lines that are not as they were written.

    Raises:
        StudyError: the file cannot be read.
    """

    file = "lines.jsonl"

    def __init__(self, folder: Path, code: str | None = None) -> None:
        self.path = folder / self.file
        self.done: dict[Any, Any] = {}
        self.stale: set[Any] = set()
        self.damaged: list[int] = []
        self._code = code
        self._whole = self._read()
        self.stale -= self.done.keys()
        if self.damaged:
            first, more = self.damaged[0], len(self.damaged) - 1
            also = f" and {more} more of its lines are" if more else " is"
            warnings.warn(f"{self.path}: line {first}{also} damaged and left out; all others count", stacklevel=2)

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
            journal._mend()
            yield journal
        finally:
            os.close(lock)

    def add(self, key: Any, value: Any) -> None:
        """Keep a result.

        Raises:
            StudyError: there is no room; what was kept before stays.
        """
        code = {} if self._code is None else {"code": self._code}
        line, new = _seal(json.dumps({**self._plain(key, value), **code}, allow_nan=False)), not self.path.exists()
        try:
            with self.path.open("ab") as file:
                file.write(line)
                file.flush()
                flush(file.fileno())
            if new:
                sync(self.path.parent)
        except OSError as error:
            raise self._not_written(error) from None
        self.done[key] = value
        self.stale.discard(key)

    def _plain(self, key: Any, value: Any) -> dict[str, Any]:
        """A line's content."""
        return {"key": key, "value": value}

    def _parsed(self, plain: Any) -> tuple[Any, Any]:
        """The inverse of `_plain`."""
        return plain["key"], plain["value"]

    def _read(self) -> list[bytes]:
        """Read what there is; the lines that are whole. What is behind the last line break was being written when the power went."""
        try:
            lines = read_bytes(self.path, MOST_BYTES, "these are no results").split(b"\n")[:-1]
        except InputError as error:
            if error.reason == MISSING:
                return []
            raise StudyError(str(self.path), "", error.reason) from None
        whole = []
        for number, line in enumerate(lines, 1):
            try:
                plain = _unseal(line, self._code)
                key, value = self._parsed(plain)
                if self._code in {None, plain.get("code")}:
                    self.done[key] = value
                else:
                    self.stale.add(key)
                whole.append(line)
            except (ValueError, KeyError, TypeError, AttributeError, RecursionError, ArithmeticError):
                self.damaged.append(number)
        return whole

    def _mend(self) -> None:
        """Leave only lines that are whole, so that more can be written behind them; damaged ones are kept in another file."""
        whole = b"".join(line + b"\n" for line in self._whole)
        self._whole = []
        try:
            if not self.damaged and self.path.exists():
                os.truncate(self.path, len(whole))
            if self.damaged:
                lines = self.path.read_bytes().split(b"\n")
                with self.path.with_name(self.path.name + DAMAGED).open("ab") as file:
                    file.writelines(lines[number - 1] + b"\n" for number in self.damaged)
                with written_whole(self.path) as part:
                    part.write_bytes(whole)
        except OSError as error:
            raise self._not_written(error) from None
        except InputError as error:
            kind = StorageError if isinstance(error, StorageError) else StudyError
            raise kind(error.source, error.key, error.reason) from None

    def _not_written(self, error: OSError) -> StudyError:
        kind = StorageError if error.errno in STORAGE else StudyError
        return kind(str(self.path), "", f"cannot be written ({error.strerror}); what was kept before stays")


def _seal(text: str) -> bytes:
    """A line with its checksum, from the text of a JSON object."""
    content = text.encode()[:-1]
    return content + b', "checksum": %d}\n' % zlib.crc32(content)


def _unseal(line: bytes, code: str | None) -> Any:
    """The JSON object of a line; those of earlier versions have no checksum.

    Args:
        line: without its line break.
        code: digest of the present source code, which writes checksums; None where any counts.

    Raises:
        ValueError: the line is not as it was written.
    """
    sealed = _SEALED.fullmatch(line)
    if sealed is None:
        plain = json.loads(line)
        if "checksum" in plain or (code is not None and plain.get("code") == code):
            raise ValueError("a line has lost its checksum")
        return plain
    if zlib.crc32(sealed["content"]) != int(sealed["checksum"]):
        raise ValueError("a line is not as it was written")
    return json.loads(sealed["content"] + b"}")
