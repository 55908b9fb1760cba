"""Inputs: checks of what was asked for, made before anything takes its time."""

from __future__ import annotations

import os
from pathlib import Path

from hotlap.core.errors import InputError

PICTURES = (".png", ".svg", ".pdf")


def check_range(option: str, value: int, least: int, most: int) -> None:
    """Refuse a number that is out of range.

    Raises:
        InputError: with the option and its range.
    """
    if not least <= value <= most:
        raise InputError(option, "", f"must be from {least} to {most}, not {value}")


def check_target(path: Path | None, suffixes: tuple[str, ...] = ()) -> None:
    """Refuse a file that could not be written.

    Args:
        path: None: none is asked for.
        suffixes: that its name may end with; none: any.

    Raises:
        InputError: with the file and the reason.
    """
    if path is None:
        return
    if path.is_dir():
        raise InputError(str(path), "", "is a folder, not a file to write")
    if not path.parent.is_dir():
        raise InputError(str(path), "", f"cannot be written: there is no folder {path.parent}")
    if not os.access(path.parent, os.W_OK) and not (path.exists() and os.access(path, os.W_OK)):
        raise InputError(str(path), "", "cannot be written: Permission denied")
    if suffixes and path.suffix.lower() not in suffixes:
        raise InputError(str(path), "", f"must end with {', '.join(suffixes)}")


def check_source(path: Path | None) -> None:
    """Refuse a file that cannot be read because it is not there.

    Raises:
        InputError: with the file and the reason.
    """
    if path is not None and not path.is_file():
        raise InputError(str(path), "", "is a folder, not a file" if path.is_dir() else "there is no such file")
