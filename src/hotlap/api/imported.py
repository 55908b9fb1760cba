"""Imported: a file of hotlap, written from one of another program."""

from __future__ import annotations

import re
from pathlib import Path

from hotlap.api.asked import Asked
from hotlap.api.inputs import as_path, check_target
from hotlap.core.errors import InputError
from hotlap.importers import read
from hotlap.importers.imported import Imported
from hotlap.system.text_files import create

_UNUSUAL = re.compile(r"[^\w.+-]+")  # in a file's name


def carry_out(asked: Asked) -> tuple[Imported, Path]:
    """Read it, and write it if there is no such file yet."""
    if asked.name is not None and not (asked.name.strip() and asked.name.isprintable()):
        raise InputError("", "name", f"must be a name, not '{asked.name}'")
    out = as_path(asked.out)
    check_target(out, (".toml",))
    imported = read(asked.file, asked.name)
    path = out or Path(f"{_UNUSUAL.sub('-', imported.name).strip('.-') or imported.kind}.toml")
    check_target(path)
    create(path, imported.text)
    return imported, path
