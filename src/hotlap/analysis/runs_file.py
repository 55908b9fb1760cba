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
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / FILE
        self.done: dict[tuple[str, int], Run] = {}
        text = self.path.read_text(encoding="utf-8") if self.path.exists() else ""
        self._whole = text.rpartition("\n")[0]  # what is behind the last line break was being written when the power went
        for number, line in enumerate(self._whole.splitlines(), 1):
            try:
                plain = json.loads(line)
                run = Run.load(plain["run"])
                self.done[plain["key"], run.seed] = run
            except (ValueError, KeyError, TypeError):
                raise StudyError(str(self.path), f"line {number}", "is damaged; delete the line, and it is flown again") from None

    @contextmanager
    def opened(self) -> Iterator[RunsFile]:
        """Hold the folder, to write.

        Raises:
            StudyError: it cannot be used, or another process holds it.
        """
        lock = hold(self.path.parent)
        try:
            if self.path.exists():
                os.truncate(self.path, len((self._whole + "\n").encode()) if self._whole else 0)
            with self.path.open("a", encoding="utf-8") as self._file:
                yield self
        finally:
            os.close(lock)

    def add(self, key: str, run: Run) -> None:
        """Keep a run."""
        self._file.write(json.dumps({"key": key, "run": run.dump()}, allow_nan=False) + "\n")
        self._file.flush()
        os.fsync(self._file.fileno())
        self.done[key, run.seed] = run
