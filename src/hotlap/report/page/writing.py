"""Writing: the built page filled with a study."""

from __future__ import annotations

from importlib.resources import files as package_files
from pathlib import Path
from typing import Any

from hotlap.analysis.robustness import Robustness
from hotlap.core.errors import HotlapError
from hotlap.report.markup import text
from hotlap.report.page.document import describe
from hotlap.report.page.encoding import write_json
from hotlap.report.page.replay import Replay, show
from hotlap.report.page.still import describe_still, title_of
from hotlap.study.snapshot import Snapshot, read_snapshot
from hotlap.study.study import Study
from hotlap.system.text_files import replace
from hotlap.worlds.world import World

REPORT = "report.html"
TITLE = "<title>hotlap</title>"
STILL = '<div id="static"></div>'
DATA = '<script id="study-data" type="application/json"></script>'


def write_report(study: Study, world: World, holds: tuple[Robustness, ...] | None = None) -> Path:
    """Write the page of a study into its folder; flies what it shows.

    Args:
        study: to be shown; it may have no flights yet.
        world: where its flights happen.
        holds: how the best parameters fare elsewhere, if that has been flown already.

    Returns:
        The file.

    Raises:
        InputError: when it cannot be written.
    """
    snapshot = read_snapshot(study)
    replay = show(snapshot.configuration, world, snapshot.best, holds)
    path = snapshot.folder / REPORT
    replace(path, render(snapshot, replay))
    return path


def render(snapshot: Snapshot, replay: Replay | None, *, live: bool = False) -> str:
    """The page as HTML."""
    return fill(load_template(), title_of(snapshot), describe_still(snapshot, replay), describe(snapshot, replay, live=live))


def load_template() -> str:
    """The page as it was built.

    Raises:
        HotlapError: this installation has none.
    """
    template = package_files("hotlap") / "report" / "page" / "template.html"
    if not template.is_file():
        raise HotlapError("this installation of hotlap lacks the built page; build it: make page")
    return template.read_text(encoding="utf-8")


def fill(template: str, title: str, still: str, document: dict[str, Any]) -> str:
    """A template with its three places filled.

    Args:
        template: holds each of `TITLE`, `STILL` and `DATA` once.
        title: of the page.
        still: HTML that reads without JavaScript.
        document: what the script reads.
    """
    contents = {
        TITLE: f"<title>{text(title)} - hotlap</title>",
        STILL: f'<div id="static">{still}</div>',
        DATA: f'<script id="study-data" type="application/json">{write_json(document)}</script>',
    }
    for place, content in contents.items():
        before, found, after = template.partition(place)
        assert found and place not in after, "the built page has each place once"  # noqa: S101, PT018  our own mistake
        template = before + content + after
    return template
