"""`hotlap reproduce NAME|all`: the paper's experiments, flown again."""

from __future__ import annotations

import shlex
from argparse import Namespace
from pathlib import Path

from hotlap.cli.flying import make_kind_ready
from hotlap.cli.output import note, present
from hotlap.cli.progress import follow_pieces
from hotlap.cli.stopping import remark
from hotlap.controllers import ControllerKind
from hotlap.errors import InputError, StudyError
from hotlap.files import replace
from hotlap.reproduce.context import Context
from hotlap.reproduce.experiments import EXPERIMENTS
from hotlap.worlds.built_in import BuiltIn

PAGE = "page.md"


def run(options: Namespace) -> int:
    """Do what is missing of each experiment, and write its page."""
    if options.jobs < 0:
        raise InputError("--jobs", "", f"must not be negative, not {options.jobs}")
    folder: Path = options.out
    if folder.exists() and not folder.is_dir():
        raise StudyError(str(folder), "", "is a file, not a folder for pages")
    pages = []
    with remark(f"nothing is lost; go on with: {shlex.join(['hotlap', 'reproduce', *options.arguments])}"):
        make_kind_ready(BuiltIn(), ControllerKind.MPC)
        for name in EXPERIMENTS if options.experiment == "all" else (options.experiment,):
            note(f"{name}:")
            context = Context(folder / (f"{name}-quick" if options.quick else name), options.quick, options.jobs, follow_pieces)
            page = EXPERIMENTS[name](context)
            path = context.folder / PAGE
            replace(path, page.markdown)
            pages.append((name, path, page))
    document = {"experiments": {name: {"page": str(path), "pictures": [str(one) for one in page.pictures]} for name, path, page in pages}}
    lines = [line for _, path, page in pages for line in (page.title, *(f"  {one}" for one in (path, *page.pictures)))]
    present(as_json=options.json, document=document, lines=lines)
    return 0
