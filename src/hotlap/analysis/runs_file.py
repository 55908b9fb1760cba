"""RunsFile: the runs of a comparison, a line for each."""

from __future__ import annotations

from typing import Any

from hotlap.analysis.comparison import Run
from hotlap.system.journal import LinesFile


class RunsFile(LinesFile):
    """Runs by the key of their cell, and their seed."""

    file = "runs.jsonl"
    done: dict[tuple[str, int], Run]

    def _plain(self, key: tuple[str, int], value: Run) -> Any:
        return {"key": key[0], "run": value.dump()}

    def _parsed(self, plain: Any) -> tuple[tuple[str, int], Run]:
        run = Run.load(plain["run"])
        return (plain["key"], run.seed), run
