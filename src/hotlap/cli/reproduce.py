"""`hotlap reproduce NAME|all`: the paper's experiments, flown again."""

from __future__ import annotations

import shlex
from argparse import Namespace
from pathlib import Path
from typing import Any

from hotlap.analysis.resumable import ResumableJobs
from hotlap.cli.flying import make_kind_ready
from hotlap.cli.output import note, present
from hotlap.cli.progress import follow_pieces
from hotlap.cli.stopping import remark
from hotlap.core.errors import StudyError
from hotlap.race.controllers import ControllerKind
from hotlap.report.article import Article
from hotlap.reproduce.experiments import EXPERIMENTS, UnavailableError, perform
from hotlap.system.engine import check_jobs, opened
from hotlap.system.text_files import replace
from hotlap.worlds.built_in import BuiltIn

PAGE, WEB = "page.md", "page.html"


def run(options: Namespace) -> int:
    """Do what is missing of each experiment, and write its page."""
    check_jobs(options.jobs, options.cluster)
    folder: Path = options.out
    if folder.exists() and not folder.is_dir():
        raise StudyError(str(folder), "", "is a file, not a folder for pages")
    pages = []
    again = f"nothing is lost; go on with: {shlex.join(['hotlap', 'reproduce', *options.arguments])}"
    with opened(options.cluster, options.jobs, note) as engine, remark(again):
        make_kind_ready(BuiltIn(), ControllerKind.MPC)
        for name in EXPERIMENTS if options.experiment == "all" else (options.experiment,):
            note(f"{name}:")
            jobs = ResumableJobs(folder / (f"{name}-quick" if options.quick else name), progress=follow_pieces, note=note, engine=engine)
            try:
                page = perform(name, jobs, quick=options.quick)
            except UnavailableError as error:
                if options.experiment != "all":
                    raise
                note(f"note: {name} is left out: {error}")
                continue
            paths = _write(jobs.folder, page)
            pages.append((name, page, paths))
    document = {"experiments": {name: _dump(page, paths) for name, page, paths in pages}}
    lines = [line for _, page, paths in pages for line in (page.title, *(f"  {one}" for one in (*paths, *page.pictures)))]
    present(as_json=options.json, document=document, lines=lines)
    return 0


def _write(folder: Path, page: Article) -> tuple[Path, Path]:
    """The page in both its forms."""
    paths = folder / PAGE, folder / WEB
    for path, content in zip(paths, (page.markdown, page.html), strict=True):
        replace(path, content)
    return paths


def _dump(page: Article, paths: tuple[Path, Path]) -> dict[str, Any]:
    """What `--json` says of a page."""
    return {"page": str(paths[0]), "html": str(paths[1]), "pictures": [str(one) for one in page.pictures]}
