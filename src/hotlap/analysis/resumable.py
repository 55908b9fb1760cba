"""Context: what an experiment is run with; its pieces of work are spread over the cores, and kept as soon as each is done."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hotlap.analysis.comparison import Cell, Run, fly_cells, missing
from hotlap.analysis.runs_file import RunsFile
from hotlap.core.version import __version__
from hotlap.system.journal import LinesFile
from hotlap.system.process_pool import spread
from hotlap.system.processors import available

Progress = Callable[[str, int, int], AbstractContextManager[Callable[[str], None]]]
"""(unit, wanted, done) -> a context, in which to call what it gives with a few words on each piece that has ended."""


@dataclass(frozen=True)
class Context:
    """Where and how an experiment is run.

    Attributes:
        folder: of the experiment: what is done is kept here, and its page and pictures are written.
        quick: the short form, under a minute.
        jobs: processes; 0 for one a processor.
        progress: shows how far it is.
    """

    folder: Path
    quick: bool
    jobs: int
    progress: Progress

    def each(self, unit: str, pieces: Mapping[str, Any], work: Callable[[Any], Iterable[Any]]) -> dict[str, Any]:
        """Results of pieces of work by key; those that are kept are not done again.

        Args:
            unit: what the pieces are, in the plural.
            pieces: by names for people; plain values, everything in which decides about a result and is kept with it.
            work: gives one result of plain JSON for a piece; a function of a module, so that workers find it.
        """
        whole = {key: f"{key} #{_digest(work.__name__, piece)}" for key, piece in pieces.items()}
        with LinesFile.opened(self.folder) as kept:
            names = {id(piece): key for key, piece in pieces.items() if whole[key] not in kept.done}
            with self.progress(unit, len(pieces), len(pieces) - len(names)) as say:
                for piece, result in spread(work, [pieces[key] for key in names.values()], self.jobs):
                    kept.add(whole[names[id(piece)]], result)
                    say(names[id(piece)])
            return {key: kept.done[whole[key]] for key in pieces}

    def compare(self, cells: Sequence[Cell]) -> list[Run]:
        """Runs of tuners, in the order of the cells; those that are kept are not flown again."""
        with RunsFile.opened(self.folder) as kept:
            keys = {id(cell): cell.key for cell in cells}
            named = {(cell.race.name, cell.tuner, cell.segments, cell.first_guess): keys[id(cell)] for cell in cells}
            groups = missing(cells, kept.done, self.jobs or available())
            wanted, left = (sum(len(cell.seeds) for cell in some) for some in (cells, [cell for group in groups for cell in group]))
            with self.progress("runs", wanted, wanted - left) as say:
                for _, (cell, run) in spread(fly_cells, groups, self.jobs):
                    kept.add((named[cell.race.name, cell.tuner, cell.segments, cell.first_guess], run.seed), run)
                    say(f"{run.race} by {run.tuner}")
            return [kept.done[keys[id(cell)], seed] for cell in cells for seed in cell.seeds]


def _digest(*values: Any) -> str:
    """Sixteen hexadecimal digits that change with anything in the values, or with the version."""
    return hashlib.sha256(repr((__version__, *values)).encode()).hexdigest()[:16]
