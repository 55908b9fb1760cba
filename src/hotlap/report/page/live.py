"""Live: the page of a study that may still be running, as of now."""

from __future__ import annotations

import threading
from pathlib import Path

from hotlap.report.page.document import describe
from hotlap.report.page.encoding import write_json
from hotlap.report.page.replay import Replay, glance, show
from hotlap.report.page.writing import render
from hotlap.study.snapshot import Snapshot, read_snapshot
from hotlap.study.study import Study
from hotlap.worlds.world import World


class LiveStudy:
    """Reads a study anew whenever it is asked, and flies again only what has changed; several threads may ask.

    Args:
        folder: of the study.
        world: where its flights happen.
    """

    def __init__(self, folder: Path, world: World) -> None:
        self._folder, self._world, self._lock = folder, world, threading.Lock()
        self._shown: dict[tuple[bytes, bool], Replay] = {}

    def page(self) -> str:
        """The whole page.

        Raises:
            StudyError: the study cannot be read.
        """
        with self._lock:
            snapshot = self._read()
            return render(snapshot, self._show(snapshot), live=True)

    def news(self, known: int = -1) -> str | None:
        """What the page reads, as JSON; None where it has all flights already.

        Args:
            known: flights that the page has, re-flights and validation included.

        Raises:
            StudyError: the study cannot be read.
        """
        with self._lock:
            snapshot = self._read()
            return None if len(snapshot.ledger) == known else write_json(describe(snapshot, self._show(snapshot), live=True))

    def _read(self) -> Snapshot:
        with Study.read(self._folder) as study:
            return read_snapshot(study)

    def _show(self, snapshot: Snapshot) -> Replay:
        """The flights of the best parameters; flown again only where these have changed, and once more when the search is over."""
        best, finished = snapshot.best, snapshot.finished
        key = best.tobytes(), finished
        if key not in self._shown:
            self._shown = {key: (show if finished else glance)(snapshot.configuration, self._world, best)}
        return self._shown[key]
