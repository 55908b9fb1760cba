"""Text files: written whole or not at all, and the operating system's complaints in its own words."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from hotlap.core.errors import InputError, StorageError

STORAGE = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EFBIG})  # what the disk does, whatever was asked for


def create(path: str | Path, text: str) -> None:
    """Write a new file whole or not at all, never over an existing one.

    Raises:
        InputError: when there is one already, or it cannot be written.
    """
    path = Path(path)
    try:
        file = path.open("x", encoding="utf-8")
        try:
            with file:
                file.write(text)
        except BaseException:
            path.unlink(missing_ok=True)
            raise
    except FileExistsError:
        raise InputError(str(path), "", "exists already and is left as it is") from None
    except (OSError, ValueError) as error:
        raise not_written(path, error) from None


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


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Gives the path of a file to write, which then takes the place of another; where it cannot, nothing of it is left.

    Raises:
        InputError: when it cannot be written.
    """
    part = path.with_name(path.name + ".part")
    try:
        yield part
        part.replace(path)
    except OSError as error:
        raise not_written(path, error) from None
    finally:
        with suppress(OSError, ValueError):
            part.unlink(missing_ok=True)


def not_written(path: str | Path, error: Exception) -> InputError:
    """The error that says why a file cannot be written: a `StorageError` where its disk is at fault, and no name that was given."""
    kind = StorageError if isinstance(error, OSError) and error.errno in STORAGE else InputError
    return kind(str(path), "", f"cannot be written: {cause_of(error)}")


def cause_of(error: Exception) -> str:
    """The operating system's words, without number and file name."""
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
