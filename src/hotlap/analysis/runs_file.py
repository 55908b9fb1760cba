"""The file of a comparison's runs: a line of JSON for each, written when it has ended; whole after a kill at any moment."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hotlap.analysis.comparison import Run
from hotlap.database import hold
from hotlap.errors import StudyError

FILE = "runs.jsonl"


class RunsFile:
    """Runs by the key of their cell, and their seed.

    Attributes:
        done: what was flown so far.

    Raises:
        StudyError: the file cannot be read.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / FILE
        self.done: dict[tuple[str, int], Run] = {}
        self._size = self._read()

    @classmethod
    @contextmanager
    def opened(cls, folder: Path) -> Iterator[RunsFile]:
        """Hold a folder, made if there is none, to write.

        Raises:
            StudyError: it cannot be used, or another process holds it.
        """
        lock = hold(folder)
        try:
            runs = cls(folder)
            if runs.path.exists():
                os.truncate(runs.path, runs._size)
            yield runs
        finally:
            os.close(lock)

    def add(self, key: str, run: Run) -> None:
        """Keep a run.

        Raises:
            StudyError: there is no room; what was kept before stays.
        """
        line = json.dumps({"key": key, "run": run.dump()}, allow_nan=False) + "\n"
        try:
            with self.path.open("ab") as file:
                file.write(line.encode())
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise StudyError(str(self.path), "", f"cannot be written ({error.strerror}); the runs so far are kept") from None
        self.done[key, run.seed] = run

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
                run = Run.load(plain["run"])
                self.done[plain["key"], run.seed] = run
            except (ValueError, KeyError, TypeError, AttributeError):
                raise StudyError(str(self.path), f"line {number}", "is damaged; delete the line, and it is flown again") from None
        return len(whole) + 1 if whole else 0
