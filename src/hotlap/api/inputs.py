"""Inputs: checks of what was asked for, made before anything takes its time."""

from __future__ import annotations

import os
from enum import StrEnum
from pathlib import Path
from typing import TypeVar

from hotlap.core.errors import InputError, UnknownNameError
from hotlap.system.regular_files import MISSING, oddity
from hotlap.system.text_files import cause_of

Name = TypeVar("Name", bound=StrEnum)


def one_of(names: type[Name], text: str, kind: str, key: str) -> Name:
    """One of some names.

    Args:
        names: all there are.
        text: the one that was given.
        kind: what they are names of.
        key: the argument that it was given as.

    Raises:
        UnknownNameError: with the names that there are.
    """
    if text not in list(names):
        raise UnknownNameError(kind, text, names, key=key)
    return names(text)


def as_path(given: str | Path | None) -> Path | None:
    """A path that was given in either form."""
    return None if given is None else Path(given)


def check_range(key: str, value: int, least: int, most: int) -> None:
    """Refuse a number that is out of range.

    Raises:
        InputError: with the argument and its range.
    """
    if not least <= value <= most:
        raise InputError("", key, f"must be from {least} to {most}, not {value}")


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
    try:
        reason = _hindrance(path)
    except (OSError, ValueError) as error:
        reason = f"cannot be written: {cause_of(error)}"
    if reason:
        raise InputError(str(path), "", reason)
    if suffixes and path.suffix.lower() not in suffixes:
        raise InputError(str(path), "", f"must end with {', '.join(suffixes)}")


def _hindrance(path: Path) -> str:
    """What keeps a file from being written; "" where nothing is known to."""
    if path.is_dir():
        return "is a folder, not a file to write"
    if not path.parent.is_dir():
        return f"cannot be written: there is no folder {path.parent}"
    allowed = os.access(path.parent, os.W_OK) or (path.exists() and os.access(path, os.W_OK))
    return "" if allowed else "cannot be written: Permission denied"


def check_source(path: Path | None) -> None:
    """Refuse a file that cannot be read because it is not there.

    Raises:
        InputError: with the file and the reason.
    """
    if path is None:
        return
    try:
        reason = oddity(path) or ("" if path.exists() else MISSING)
    except (OSError, ValueError) as error:
        reason = f"cannot be read: {cause_of(error)}"
    if reason:
        raise InputError(str(path), "", reason)
