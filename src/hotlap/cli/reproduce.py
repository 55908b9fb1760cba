"""`hotlap reproduce NAME|all`: the paper's experiments, flown again."""

from __future__ import annotations

import shlex
from argparse import Namespace
from pathlib import Path
from typing import Any

from hotlap.analysis.comparison import RunJournal
from hotlap.analysis.resumable import ResumableJobs
from hotlap.cli.flying import make_kind_ready
from hotlap.cli.output import note, present
from hotlap.cli.progress import follow_pieces
from hotlap.cli.stopping import remark
from hotlap.race.controllers import ControllerKind
from hotlap.report.article import Article, Heading, Paragraph
from hotlap.reproduce.experiments import EXPERIMENTS, UnavailableError, perform
from hotlap.system.engine import check_jobs, opened
from hotlap.system.journal import Journal
from hotlap.system.regular_files import check_folder
from hotlap.system.text_files import replace
from hotlap.worlds.built_in import BuiltIn

PAGE, WEB = "page.md", "page.html"


def run(options: Namespace) -> int:
    """Do what is missing of each experiment, and write its page."""
    check_jobs(options.jobs, options.cluster)
    folder: Path = options.out
    check_folder(folder, "a folder for pages")
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
            again = shlex.join(["hotlap", "reproduce", name, *["--quick"] * options.quick, "--out", str(folder)])
            paths = _write(jobs.folder, page, again)
            pages.append((name, page, paths))
    document = {"experiments": {name: _dump(page, paths) for name, page, paths in pages}}
    lines = [line for _, page, paths in pages for line in (page.title, *(f"  {one}" for one in (*paths, *page.pictures)))]
    present(as_json=options.json, document=document, lines=lines)
    return 0


def _write(folder: Path, page: Article, command: str) -> tuple[Path, Path]:
    """The page in both its forms; in HTML with the command that does it again and the runs behind it."""
    paths = folder / PAGE, folder / WEB
    kept = [file for file in (RunJournal.file, Journal.file) if (folder / file).is_file()]
    end = [Heading("Run it again"), Paragraph(f"`{command}`")]
    web = Article(page.title, [*page.parts, *end], next(iter(kept), ""), page.style, page.script)
    for path, content in zip(paths, (page.markdown, web.html), strict=True):
        replace(path, content)
    return paths


def _dump(page: Article, paths: tuple[Path, Path]) -> dict[str, Any]:
    """What `--json` says of a page."""
    return {"page": str(paths[0]), "html": str(paths[1]), "pictures": [str(one) for one in page.pictures]}
