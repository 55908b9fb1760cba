"""Resumable jobs: pieces of work spread over processes or a cluster, whose results are kept in a folder as soon as each is there.

What is kept is not computed again, unless the source code that decides about it, or its data, have changed since.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hotlap.analysis.comparison import Cell, Run, RunJournal, fly_cells, missing
from hotlap.core.shown import in_full
from hotlap.system.engine import Engine
from hotlap.system.journal import Journal
from hotlap.system.package_data import digest_packages
from hotlap.system.process_pool import Processes

DECIDING = ("core", "dynamics", "race", "reference", "reference_files", "flight", "planning", "worlds", "tuners", "tuning", "first_guess")
"""Packages that decide about a flight, and so about all that is computed from flights."""

Progress = Callable[[str, int, int], AbstractContextManager[Callable[[str], None]]]
"""(unit, wanted, done) -> a context, in which to call what it gives with a few words on each piece that has ended."""


@contextmanager
def no_progress(_unit: str, _wanted: int, _done: int) -> Iterator[Callable[[str], None]]:
    """Progress that shows nothing."""
    yield lambda _words: None


def describe_run(run: Run) -> str:
    """A run in few words."""
    return f"{run.race} by {run.tuner}"


def digest_code(source: str | Path) -> str:
    """Sixteen hexadecimal digits that change with the source code that decides about a result, and with its data.

    Args:
        source: dotted name or path of the module that computes it, beside the packages that are `DECIDING`.
    """
    return digest_packages(DECIDING, source)


@dataclass
class ResumableJobs:
    """Where and how jobs are run; the same jobs in the same folder continue after an interruption.

    Attributes:
        folder: where results are kept, made if there is none.
        processes: how many work at once; 0 for one a processor.
        progress: shows how far it is.
        note: called with a line that a person should know of.
        engine: where the work is done; None: so many processes of this machine.
    """

    folder: Path
    processes: int = 0
    progress: Progress = no_progress
    note: Callable[[str], None] = lambda _line: None
    engine: Engine | None = None
    _warned: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        self._engine = self.engine or Processes(self.processes, self.note)

    @property
    def cluster(self) -> Engine | None:
        """The engine, where its workers are no processes of this machine."""
        return None if isinstance(self._engine, Processes) else self._engine

    def each(self, unit: str, pieces: Mapping[str, Any], work: Callable[[Any], Iterable[Any]]) -> dict[str, Any]:
        """Results of pieces of work by name; those that are kept are not computed again.

        Args:
            unit: what the pieces are, in the plural.
            pieces: by names for people; plain values that hold everything that decides about a result, the code apart.
            work: gives one result of plain JSON for a piece; a function of a module, so that worker processes find it.
        """
        keys = {name: f"{name} #{_digest(work.__name__, piece)}" for name, piece in pieces.items()}
        with Journal.opened(self.folder, digest_code(work.__module__)) as kept:
            names = {id(pieces[name]): name for name, key in keys.items() if key not in kept.done}

            def keep(piece: Any, result: Any) -> str:
                name = names[id(piece)]
                kept.add(keys[name], result)
                return name

            self._run(kept, unit, keys.values(), [pieces[name] for name in names.values()], work, keep)
            return {name: kept.done[key] for name, key in keys.items()}

    def compare(self, cells: Sequence[Cell], describe: Callable[[Run], str] = describe_run) -> list[Run]:
        """Runs of tuners, in the order of the cells; those that are kept are not flown again.

        Args:
            cells: no two of the same race, tuner, segmentation rule and first guess.
            describe: words for the progress on a run that has ended.
        """
        keys = {_combination(cell): cell.key for cell in cells}
        wanted = [(keys[_combination(cell)], seed) for cell in cells for seed in cell.seeds]
        with RunJournal.opened(self.folder, digest_code(fly_cells.__module__)) as kept:
            groups = missing(cells, kept.done, self._engine.workers)
            if before := sum(key in kept.done for key in wanted):
                self.note(f"{kept.path}: {before} of {len(wanted)} runs are there already")

            def keep(_group: Any, result: tuple[Cell, Run]) -> str:
                cell, run = result
                kept.add((keys[_combination(cell)], run.seed), run)
                return describe(run)

            self._run(kept, "runs", wanted, groups, fly_cells, keep)
            return [kept.done[key] for key in wanted]

    def _run(
        self,
        kept: Journal,
        unit: str,
        wanted: Collection[Any],
        pieces: Sequence[Any],
        work: Callable[[Any], Iterable[Any]],
        keep: Callable[[Any, Any], str],
    ) -> None:
        """The loop over what is missing.

        Args:
            kept: results so far.
            unit: what is counted.
            wanted: keys of all results asked for.
            pieces: of work that give those that are missing.
            work: gives the results of a piece.
            keep: adds a result of a piece to `kept`, and says in a few words what it is.
        """
        if not self._warned and any(key in kept.stale for key in wanted):
            self._warned = True
            self.note(f"{kept.path}: results of other source code than this are not used; they are computed again")
        with self.progress(unit, len(wanted), sum(key in kept.done for key in wanted)) as say:
            for piece, result in self._engine.spread(work, pieces):
                say(keep(piece, result))


def _combination(cell: Cell) -> tuple[str, str, str, str]:
    """What tells the cells of one comparison apart."""
    return cell.race.name, cell.tuner, cell.segments, cell.first_guess


def _digest(*values: Any) -> str:
    """Sixteen hexadecimal digits that change with anything in the values."""
    return hashlib.sha256(in_full(values).encode()).hexdigest()[:16]
