"""`hotlap watch DIR`: the page of a study, or of all studies of a folder, in the browser, while flights come in."""

from __future__ import annotations

import signal
import sys
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from hotlap import worlds
from hotlap.api.inputs import check_range
from hotlap.cli.flying import make_ready
from hotlap.cli.output import note, present
from hotlap.cli.stopping import Stopped
from hotlap.study.database import FILE
from hotlap.study.glance import find_studies
from hotlap.study.study import Study
from hotlap.system.regular_files import is_there
from hotlap.worlds.world import is_slow

if TYPE_CHECKING:
    from hotlap.report.server import Source


def run(options: Namespace) -> int:
    """Serve until Ctrl-C."""
    check_range("port", options.port, 0, 65535)
    folder: Path = options.study
    several = not is_there(folder / FILE) and next(find_studies(folder), None) is not None
    if several:
        _serve(options, *_studies(folder), "are shown")
    else:
        _serve(options, _open(folder), lambda _: None, "is shown")
    return 0


def _serve(options: Namespace, source: Source, below: Callable[[str], Source | None], shown: str) -> None:
    """Answer browsers until Ctrl-C."""
    from hotlap.report.page.writing import load_template  # noqa: PLC0415  it loads the flight core
    from hotlap.report.server import Server  # noqa: PLC0415  likewise

    load_template()  # a page that was not built is said here, not to the browser
    try:
        with Server(source, options.host, options.port, below) as server:
            if options.json:
                present(as_json=True, document={"study": str(options.study), "address": server.address}, lines=())
                sys.stdout.flush()
            note(f"{options.study} {shown} at {server.address} until Ctrl-C")
            server.serve_forever()
    except Stopped as stop:
        if stop.signal != signal.SIGINT:
            raise


def _studies(folder: Path) -> tuple[Source, Callable[[str], Source | None]]:
    """The page of a folder of studies, and what finds those of each."""
    from hotlap.report.studies_page import StudiesPage  # noqa: PLC0415  only for folders

    page = StudiesPage(folder, _open)
    return page, page.study


def _open(folder: Path) -> Source:
    """The live page of a study.

    Raises:
        StudyError: there is none, or it cannot be read.
    """
    with Study.read(folder) as study:
        world = worlds.build(study.configuration.world)
        if is_slow(world):
            note(f"note: the flights shown are of the built-in world; {world.name} flies for the study alone")
            world = worlds.build(worlds.DEFAULT)
        make_ready(world, study.configuration.scenario)
    from hotlap.report.page.writing import LiveStudy  # noqa: PLC0415  it loads the flight core

    return LiveStudy(folder, world)
