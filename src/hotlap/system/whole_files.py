"""Whole files: written beside their place under a name that nobody can foresee, and moved there when all of it is on the disk.

A name that can be foreseen could be a link that someone has laid there, and the file that it leads to would be overwritten.
"""

from __future__ import annotations

import errno
import os
import secrets
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from hotlap.core.errors import InputError, StorageError
from hotlap.system.drive import flush

STORAGE = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EFBIG})  # what the disk does, whatever was asked for
BEGINNING, ENDING = ".hotlap-", ".part"
NEW = os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
ABANDONED = 3600.0  # s after which a part belongs to a process that was killed


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Gives the path of a new, empty file to write, which then takes the place of another, also after a power failure.

    Where it cannot, nothing of it is left.

    Raises:
        InputError: when it cannot be written.
    """
    try:
        _refuse_devices(path)
        part = new_part(path.parent)
        try:
            yield part
            sync(part)
            part.replace(path)
            sync(path.parent)
        finally:
            with suppress(OSError):
                part.unlink(missing_ok=True)
    except OSError as error:
        raise not_written(path, error) from None


def new_part(folder: Path, mode: int = 0o666) -> Path:
    """A new, empty file for what is to be moved to its place later; removes those that killed processes have left.

    Args:
        folder: where it is made, and has to be moved within.
        mode: its permissions, less those of the umask.

    Raises:
        OSError: it cannot be made.
    """
    part = folder / f"{BEGINNING}{secrets.token_hex(8)}{ENDING}"
    os.close(os.open(part, os.O_WRONLY | NEW, mode))
    remove_abandoned(folder)
    return part


def sync(path: Path) -> None:
    """Have a file or a folder written to the disk; a folder for which that cannot be done, or that cannot be read, is no error."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
        try:
            flush(descriptor)
        finally:
            os.close(descriptor)
    except OSError:
        if not path.is_dir():
            raise


def not_written(path: str | Path, error: Exception) -> InputError:
    """The error that says why a file cannot be written: a `StorageError` where its disk is at fault, and no name that was given."""
    kind = StorageError if isinstance(error, OSError) and error.errno in STORAGE else InputError
    return kind(str(path), "", f"cannot be written: {cause_of(error)}")


def cause_of(error: Exception) -> str:
    """The operating system's words, without number and file name."""
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def _refuse_devices(path: Path) -> None:
    """A file takes the place of a file alone, not of a device, a pipe or a socket."""
    with suppress(FileNotFoundError):
        if not (stat.S_ISREG(path.stat().st_mode) or path.is_dir()):
            raise OSError(0, "is no ordinary file")


def remove_abandoned(folder: Path, pattern: str = f"{BEGINNING}*{ENDING}") -> None:
    """Remove old parts of one's own, and nothing else.

    Args:
        folder: where they lie.
        pattern: of their names.
    """
    with suppress(OSError):
        for part in folder.glob(pattern):
            with suppress(OSError):
                status = part.lstat()
                old = time.time() - status.st_mtime > ABANDONED
                if old and stat.S_ISREG(status.st_mode) and status.st_uid == os.getuid():
                    part.unlink()
