"""`hotlap new KIND NAME`: a commented file to start from."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from hotlap.cli.output import present
from hotlap.errors import InputError
from hotlap.files import Kind, create
from hotlap.templates import new


def run(options: Namespace) -> int:
    """Write NAME.toml, never over an existing file."""
    path = Path(options.name.removesuffix(".toml") + ".toml")
    name = path.stem.strip()
    if not name or not options.name.isprintable() or path.name == ".toml":
        raise InputError("NAME", "", f"must be a name or the path of a new file, not '{options.name}'")
    kind = Kind(options.kind)
    create(path, new(kind, name))
    use = f"hotlap check {path}"
    document = {"kind": kind, "name": name, "file": str(path)}
    present(as_json=options.json, document=document, lines=[f"wrote {path}; edit it, then: {use}"])
    return 0
