"""Text files: written whole or not at all, and the operating system's complaints in its own words."""

from __future__ import annotations

from pathlib import Path
from typing import TextIO

from hotlap.core.errors import InputError


def create(path: str | Path, text: str) -> None:
    """Write a new file, never over an existing one.

    Raises:
        InputError: when there is one already, or it cannot be written.
    """
    try:
        with Path(path).open("x", encoding="utf-8") as file:
            _fill(file, text)
    except FileExistsError:
        raise InputError(str(path), "", "exists already and is left as it is") from None
    except (OSError, ValueError) as error:
        raise InputError(str(path), "", f"cannot be written: {cause_of(error)}") from None


def replace(path: str | Path, text: str) -> None:
    """Write a file whole or not at all, over an older one if there is one.

    Raises:
        InputError: when it cannot be written.
    """
    path = Path(path)
    try:
        part = path.with_name(path.name + ".part")
        with part.open("w", encoding="utf-8") as file:
            _fill(file, text)
        part.replace(path)
    except (OSError, ValueError) as error:
        raise InputError(str(path), "", f"cannot be written: {cause_of(error)}") from None


def _fill(file: TextIO, text: str) -> None:
    """Write a new file; where the disk is full or the user interrupts, nothing of it stays."""
    try:
        file.write(text)
        file.flush()
    except BaseException:
        Path(file.name).unlink(missing_ok=True)
        raise


def cause_of(error: Exception) -> str:
    """The operating system's words, without number and file name."""
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
