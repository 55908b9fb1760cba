"""`hotlap new KIND NAME`: a commented file to start from."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from hotlap.api.inputs import check_target
from hotlap.cli.output import present
from hotlap.core.errors import InputError
from hotlap.files.descriptions import Kind, load_quadrotor, load_track
from hotlap.files.templates import new
from hotlap.system.text_files import create

LOADS = {"track": load_track, "vehicle": load_quadrotor}  # keys of a race that may be given


def run(options: Namespace) -> int:
    """Write NAME.toml, never over an existing file."""
    path = Path(options.name.removesuffix(".toml") + ".toml")
    name = path.stem.strip()
    if not name or not options.name.isprintable() or path.name == ".toml":
        raise InputError("NAME", "", f"must be a name or the path of a new file, not '{options.name}'")
    kind, values = Kind(options.kind), _values(options)
    check_target(path)
    create(path, new(kind, name, values))
    use = f"hotlap check {path}"
    document = {"kind": kind, "name": name, "file": str(path)}
    present(as_json=options.json, document=document, lines=[f"wrote {path}; edit it, then: {use}"])
    return 0


def _values(options: Namespace) -> dict[str, str]:
    """What a race is to be made of; it is looked at before anything is written."""
    values = {key: getattr(options, key) for key in LOADS if getattr(options, key) is not None}
    for key, value in values.items():
        if options.kind != Kind.RACE:
            raise InputError(f"--{key}", "", f"is of a race, not of a {options.kind}")
        LOADS[key](value)
    return values
