"""`hotlap import FILE`: a track or quadrotor from a file of another program."""

from __future__ import annotations

import shlex
from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path

from hotlap.api.importing import import_file
from hotlap.cli.options import arguments_of
from hotlap.cli.output import present
from hotlap.core.printable import printable
from hotlap.importers.imported import Imported


def run(options: Namespace) -> int:
    """Write it, never over an existing file, and say what it says at its top."""
    imported, path = import_file(**arguments_of(import_file, options))
    document = {
        "kind": str(imported.kind),
        "name": imported.name,
        "file": str(path),
        "format": imported.format,
        "taken": list(imported.taken),
        "lost": list(imported.lost),
    }
    present(as_json=options.json, document=document, lines=_lines(imported, path))
    return 0


def _lines(imported: Imported, path: Path) -> Iterator[str]:
    """What was written, what was assumed, what is missing, and what to do next."""
    yield f"wrote {path}: a {imported.kind}, from {imported.format}"
    for title, remarks in (("taken as", imported.taken), ("not carried over", imported.lost)):
        if remarks:
            yield title
            yield from (f"  {printable(remark)}" for remark in remarks)
    yield f"next: hotlap check {shlex.quote(str(path))}"
