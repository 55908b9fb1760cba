"""Writing: the page of a study, as a file or for a browser that watches while the search runs."""

from __future__ import annotations

import threading
from importlib.resources import files as package_files
from pathlib import Path
from typing import Any

from hotlap.core.errors import HotlapError
from hotlap.report.markup import text
from hotlap.report.page.document import dump_study, write_json
from hotlap.report.page.replay import Replay, replay_finished, replay_running
from hotlap.report.page.static import render_static, title_of
from hotlap.study.snapshot import Snapshot, read_snapshot
from hotlap.study.study import Study, count_flights
from hotlap.system.text_files import replace
from hotlap.worlds.world import World

REPORT = "report.html"
TITLE = "<title>hotlap</title>"
STATIC = '<div id="static"></div>'
DATA = '<script id="study-data" type="application/json"></script>'


def write_report(study: Study, world: World) -> Path:
    """Write the page of a study into the folder of the study; the flights that the page shows are flown here.

    Args:
        study: it may have no flights yet.
        world: where its flights happen.

    Returns:
        The file.

    Raises:
        InputError: when it cannot be written.
    """
    snapshot = read_snapshot(study)
    return write_replay(snapshot, replay_finished(snapshot.configuration, world, snapshot.best, hold=snapshot.hold))


def write_replay(snapshot: Snapshot, replay: Replay) -> Path:
    """Write the page of a study whose flights are flown again already; returns the file.

    Raises:
        InputError: when it cannot be written.
    """
    path = snapshot.folder / REPORT
    replace(path, render(snapshot, replay))
    return path


def render(snapshot: Snapshot, replay: Replay | None, *, live: bool = False) -> str:
    """The page as HTML; arguments as for `dump_study`."""
    return fill(load_template(), title_of(snapshot), render_static(snapshot, replay), dump_study(snapshot, replay, live=live))


def load_template() -> str:
    """The built page, without a study.

    Raises:
        HotlapError: this installation has none.
    """
    template = package_files("hotlap") / "report" / "page" / "template.html"
    if not template.is_file():
        raise HotlapError("this installation of hotlap lacks the built page; build it: make page")
    return template.read_text(encoding="utf-8")


def fill(template: str, title: str, static: str, document: dict[str, Any]) -> str:
    """The template with its three placeholders replaced.

    Args:
        template: contains each of `TITLE`, `STATIC` and `DATA` once.
        title: of the page.
        static: HTML for readers without JavaScript.
        document: the data that the script of the page reads.
    """
    contents = {
        TITLE: f"<title>{text(title)} - hotlap</title>",
        STATIC: f'<div id="static">{static}</div>',
        DATA: f'<script id="study-data" type="application/json">{write_json(document)}</script>',
    }
    for place, content in contents.items():
        before, found, after = template.partition(place)
        assert found and place not in after, "the built page has each place once"  # noqa: S101, PT018  our own mistake
        template = before + content + after
    return template


class LiveStudy:
    """The page of a study that may still be running, for a server; several threads may ask.

    A poll costs one short query while nothing changes. Flights are replayed only when the best parameters have changed.

    Args:
        folder: of the study.
        world: where its flights happen.
    """

    def __init__(self, folder: Path, world: World) -> None:
        self._folder, self._world, self._lock = folder, world, threading.Lock()
        self._replays: dict[tuple[bytes, bool, str], Replay] = {}

    def page(self) -> str:
        """The whole page as HTML.

        Raises:
            StudyError: the study cannot be read.
        """
        with self._lock:
            snapshot = self._read()
            return render(snapshot, self._replay(snapshot), live=True)

    def news(self, known: int = -1) -> str | None:
        """The document of the page as JSON; None where no flights were added.

        Args:
            known: number of flights that the page has, re-flights and validation included.

        Raises:
            StudyError: the study cannot be read.
        """
        with self._lock:
            if count_flights(self._folder) == known:
                return None
            snapshot = self._read()
            return write_json(dump_study(snapshot, self._replay(snapshot), live=True))

    def _read(self) -> Snapshot:
        with Study.read(self._folder) as study:
            return read_snapshot(study)

    def _replay(self, snapshot: Snapshot) -> Replay:
        """The last replay while the best parameters stay the same; a full one when the search is over."""
        best, finished = snapshot.best, snapshot.finished
        key = best.tobytes(), finished, snapshot.hold
        if key not in self._replays:
            asked, world = snapshot.configuration, self._world
            full = replay_finished(asked, world, best, hold=snapshot.hold) if finished else None
            self._replays = {key: full or replay_running(asked, world, best)}
        return self._replays[key]
