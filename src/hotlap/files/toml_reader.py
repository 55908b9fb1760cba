"""TOML in: the table of a file, or one line on why there is none."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from hotlap.core.errors import InputError
from hotlap.files.bounds import DEEPEST, deep_key, keep_bounds
from hotlap.system.regular_files import is_there, read_text

MAX_BYTES = 1_000_000  # a description takes a few thousand
STUDY = "parameters.toml"  # what the folder of a study has
IMPORTED = "is a file of another program: hotlap import reads it"
ELSEWHERE: Mapping[str, str] = {  # files that are no TOML, by their endings, and what takes them
    ".csv": "is a table of numbers, no TOML: a reference is given beside its race, with reference=...",
    ".json": "is JSON, no TOML: what was learnt is given beside a race, with first_guess=...",
    **dict.fromkeys((".yaml", ".yml", ".sdf", ".urdf", ".xacro", ".xml", ".world"), IMPORTED),
}


def read(path: Path | Traversable, label: str) -> dict[str, Any]:
    """The table of a TOML file.

    Args:
        path: the file.
        label: what messages call it.

    Raises:
        InputError: when it cannot be read, or is no TOML.
    """
    if isinstance(path, Path) and is_there(path / STUDY):
        raise InputError(label, "", "is the folder of a study, not a file: give the race, and this folder with parameters=...")
    text = read_text(path, MAX_BYTES, label=label) if isinstance(path, Path) else path.read_text(encoding="utf-8")
    try:
        return parse(text, label)
    except ValueError as error:
        raise InputError(label, "", ELSEWHERE.get(Path(path.name).suffix.lower()) or f"is not valid TOML: {error}") from None


def parse(text: str, label: str) -> dict[str, Any]:
    """The table of TOML, within the bounds of what people write.

    Raises:
        InputError: it is nested too deeply, or too long.
        ValueError: it is no TOML.
    """
    number = deep_key(text)
    if number:
        raise InputError(label, f"line {number}", f"is nested too deeply: a key has more than {DEEPEST} parts")
    try:
        return keep_bounds(tomllib.loads(text), label)
    except RecursionError:
        raise InputError(label, "", "is nested too deeply") from None
