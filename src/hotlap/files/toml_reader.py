"""TOML in: the table of a file, or one line on why there is none."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from hotlap.core.errors import InputError
from hotlap.files.bounds import keep_bounds
from hotlap.system.text_files import cause_of

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
    try:
        if not path.is_file():
            raise InputError(label, "", _folder(path) if path.is_dir() else "is not a file of text")
        content = path.read_bytes() if not isinstance(path, Path) or path.stat().st_size <= MAX_BYTES else None
        if content is None:
            raise InputError(label, "", f"is larger than {MAX_BYTES / 1e6:g} MB: this is not a description")
        return keep_bounds(tomllib.loads(content.decode("utf-8-sig")), label)
    except UnicodeDecodeError as error:
        raise InputError(label, "", f"is not UTF-8 text (byte {error.start + 1})") from None
    except RecursionError:
        raise InputError(label, "", "is not valid TOML: nested too deeply") from None
    except OSError as error:
        raise InputError(label, "", f"cannot be read: {cause_of(error)}") from None
    except ValueError as error:
        raise InputError(label, "", ELSEWHERE.get(Path(path.name).suffix.lower()) or f"is not valid TOML: {error}") from None


def _folder(path: Path | Traversable) -> str:
    """What a folder is, where a file was expected."""
    if (path / STUDY).is_file():
        return "is the folder of a study, not a file: give the race, and this folder with parameters=..."
    return "is a folder, not a file"
