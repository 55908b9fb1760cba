"""Regular files: how every file of a user is opened: a pipe is not waited for, a device not read, and there is a limit to its size."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path

from hotlap.core.errors import InputError, StudyError
from hotlap.system.text_files import cause_of

MISSING = "there is no such file"
PART = 1 << 20  # bytes that are read at a time
_KINDS: tuple[tuple[Callable[[int], bool], str], ...] = (
    (stat.S_ISDIR, "is a folder, not a file"),
    (stat.S_ISFIFO, "is a pipe, not a file: write what comes out of it into a file, and give that"),
    (stat.S_ISSOCK, "is a socket, not a file"),
    (stat.S_ISCHR, "is a device, not a file"),
    (stat.S_ISBLK, "is a device, not a file"),
)


def oddity(path: Path) -> str:
    """What stands in the place of a regular file, as "is a folder, not a file"; "" where it is one, or nothing is there.

    Raises:
        OSError: it cannot be told.
        ValueError: this is no path.
    """
    try:
        return _oddity(path.stat().st_mode)
    except (FileNotFoundError, NotADirectoryError):
        return ""


def is_there(path: Path) -> bool:
    """Whether something has this path; false where it is too long to be one, or cannot be looked up."""
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def is_folder(path: Path) -> bool:
    """Whether a folder has this path; false likewise."""
    return is_there(path) and path.is_dir()


def check_folder(folder: Path, meant: str) -> None:
    """Refuse a path that neither is that of a folder, nor can become one.

    Args:
        folder: the path.
        meant: what it is given for, as "the folder of a study".

    Raises:
        StudyError: with the path and the reason.
    """
    try:
        taken = folder.exists() and not folder.is_dir()
    except (OSError, ValueError) as error:
        raise StudyError(str(folder), "", f"cannot be used as {meant}: {cause_of(error)}") from None
    if taken:
        raise StudyError(str(folder), "", f"is a file, not {meant}")


def read_bytes(path: str | Path, most: int, meant: str = "this is not a description", label: str = "") -> bytes:
    """What stands in a regular file.

    Args:
        path: of the file.
        most: bytes that it may have.
        meant: what is said of a larger one.
        label: what messages call it; "" for its path.

    Raises:
        InputError: there is none, something else is in its place, it cannot be read, or it is too large.
    """
    label = label or str(path)
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOCTTY)
    except FileNotFoundError:
        raise InputError(label, "", MISSING) from None
    except OSError as error:
        raise InputError(label, "", f"cannot be read: {cause_of(error)}") from None
    except ValueError as error:
        raise InputError(label, "", f"is no usable path: {cause_of(error)}") from None
    try:
        odd = _oddity(os.fstat(handle).st_mode)
        if odd:
            raise InputError(label, "", odd)
        content = read_at_most(handle, most)
    except OSError as error:
        raise InputError(label, "", f"cannot be read: {cause_of(error)}") from None
    finally:
        os.close(handle)
    if len(content) > most:
        raise InputError(label, "", f"is larger than {most / 1e6:g} MB: {meant}")
    return content


def read_at_most(handle: int, most: int) -> bytes:
    """What stands in an open file; more than `most` bytes where it is larger. Takes no more memory than there is to read.

    Raises:
        OSError: it cannot be read.
    """
    parts, size = list[bytes](), 0
    while size <= most and (part := os.read(handle, PART)):
        parts.append(part)
        size += len(part)
    return b"".join(parts)


def read_text(path: str | Path, most: int, meant: str = "this is not a description", label: str = "") -> str:
    """What stands in a regular file of UTF-8 text, with or without a mark at its beginning; arguments as for `read_bytes`.

    Raises:
        InputError: likewise, and where it is no such text.
    """
    try:
        return read_bytes(path, most, meant, label).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(label or str(path), "", f"is not UTF-8 text (byte {error.start + 1})") from None


def _oddity(mode: int) -> str:
    """As `oddity`, of a mode."""
    return "" if stat.S_ISREG(mode) else next((said for kind, said in _KINDS if kind(mode)), "is not a file of text")
