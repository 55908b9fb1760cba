"""Text files: written whole or not at all."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from hotlap.core.errors import InputError
from hotlap.system.whole_files import cause_of, new_part, not_written, sync, written_whole


def create(path: str | Path, text: str) -> None:
    """Write a new file whole or not at all, never over an existing one.

    Raises:
        InputError: when there is one already, or it cannot be written.
    """
    path = Path(path)
    try:
        part = new_part(path.parent)
        try:
            part.write_text(text, encoding="utf-8")
            sync(part)
            _name_new(part, path)
            sync(path.parent)
        finally:
            with suppress(OSError):
                part.unlink(missing_ok=True)
    except FileExistsError:
        raise InputError(str(path), "", "exists already and is left as it is") from None
    except (OSError, ValueError) as error:
        raise not_written(path, error) from None


def _name_new(part: Path, path: Path) -> None:
    """Give a file its name, which nothing may have yet."""
    try:
        path.hardlink_to(part)
    except OSError:
        if os.path.lexists(path):
            raise FileExistsError from None
        part.replace(path)  # a file system without second names


def replace(path: str | Path, text: str) -> None:
    """Write a file whole or not at all, over an older one if there is one.

    Raises:
        InputError: when it cannot be written.
    """
    try:
        with written_whole(Path(path)) as part:
            part.write_text(text, encoding="utf-8")
    except ValueError as error:
        raise InputError(str(path), "", f"cannot be written: {cause_of(error)}") from None
