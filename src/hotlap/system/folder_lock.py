"""Folder lock: one process at a time works in a folder; the lock goes with the process, however that ends."""

from __future__ import annotations

import errno
import fcntl
import os
from contextlib import suppress
from pathlib import Path

from hotlap.core.errors import StudyError
from hotlap.system.text_files import cause_of

LOCK = "study.lock"
NO_LOCKS = frozenset({errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOTSUP, errno.EINVAL})  # as Lustre or NFS may be mounted


def hold(folder: Path) -> int:
    """Make a folder and lock it; the lock goes with the process, however that ends.

    Returns:
        The descriptor to close.

    Raises:
        StudyError: it cannot be made or locked, or another process holds it.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o644)
    except (OSError, ValueError) as error:
        raise StudyError(str(folder), "", f"cannot be used as the folder of a study: {cause_of(error)}") from None
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        holder = _holder(lock)
        os.close(lock)
        who = f"process {holder}" if holder else "another process"
        raise StudyError(str(folder), "", f"{who} is working on this study; wait for it, or give another folder") from None
    except OSError as error:
        os.close(lock)
        why = "its file system has no locks, which keep two processes apart" if error.errno in NO_LOCKS else "it cannot be locked"
        raise StudyError(str(folder), "", f"{why} ({cause_of(error)}); give a folder on another disk") from None
    with suppress(OSError):  # a courtesy to whoever is refused
        os.ftruncate(lock, 0)
        os.pwrite(lock, f"{os.getpid()}\n".encode(), 0)
    return lock


def holder_of(folder: Path) -> int:
    """The process that locked a folder last, 0 where none is known."""
    try:
        handle = os.open(folder / LOCK, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except (OSError, ValueError):
        return 0
    try:
        return int(_holder(handle))
    except ValueError:
        return 0
    finally:
        os.close(handle)


def _holder(lock: int) -> str:
    """What the process that holds a lock has written into it."""
    with suppress(OSError):  # something else is in its place
        return os.pread(lock, 20, 0).decode(errors="replace").strip()
    return ""
