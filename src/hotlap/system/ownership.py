"""Ownership: whether only oneself can write to a folder, so that what lies in it can be trusted.

Trusted are oneself, root, and whoever owns the root of the file system. Others may be able to read, never to write: neither the folder
nor one above it, since a folder can be replaced from above. Folders of the sticky kind, as /tmp, let everybody replace his own alone.
"""

from __future__ import annotations

import errno
import grp
import os
import pwd
import stat
from contextlib import suppress
from functools import cache
from pathlib import Path

MOST_LINKS = 40  # symbolic links in a path, as Linux has it
TEMPORARY = "HOTLAP_TEMPORARY_CACHE"  # environment variable: a folder that a process has made for itself and those that it starts


def make_private(folder: Path) -> None:
    """Make a folder, and those above it that are missing, for oneself alone, whatever the umask.

    Raises:
        OSError: it cannot be made, or cannot be trusted, as somebody else may have been faster.
    """
    missing = [folder] if not folder.is_dir() else []
    while missing and not missing[-1].parent.is_dir():
        missing.append(missing[-1].parent)
    for place in reversed(missing):
        try:
            place.mkdir(0o700)
        except FileExistsError:  # another process was faster, or it is no folder
            if not place.is_dir():
                raise
        else:
            place.chmod(0o700)  # an umask may have taken more away than others' rights
    reason = doubt(folder.absolute())
    if reason:
        raise PermissionError(errno.EACCES, reason, str(folder))


def temporary() -> Path | None:
    """The folder that this process, or the one that has started it, has made in place of one that it does not trust.

    What is above it does not count: nobody else has such a folder, and every file of it is looked at when it is opened.
    """
    place = Path(os.environ.get(TEMPORARY, ""))
    return place if place.is_absolute() and is_private(place) else None


def is_private(folder: Path) -> bool:
    """Whether a path is that of a folder, not of a link to one, that is one's own and open to nobody else."""
    with suppress(OSError):
        status = folder.lstat()
        return stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and stat.S_IMODE(status.st_mode) == 0o700
    return False


def doubt(folder: Path) -> str:
    """Why a folder cannot be trusted, in one clause that names it; "" where it can be, or is still to be made in one that can.

    What cannot be looked at is no reason: nothing can be read there, nor written.

    Args:
        folder: absolute; need not exist. Links in its path are followed, and have to be trusted themselves.
    """
    with suppress(OSError):
        return _doubt(folder)
    return ""


def _doubt(folder: Path) -> str:
    """As `doubt`, a step at a time from the root on."""
    top = temporary()
    place = top if top is not None and folder.is_relative_to(top) else Path(folder.anchor)
    rest, links = list(reversed(folder.relative_to(place).parts)), 0
    while rest:
        status = place.lstat()
        if _others_write(status) and not status.st_mode & stat.S_ISVTX:
            return f"others may write to {place}"
        part = rest.pop()
        found = place.parent if part == ".." else place / part
        status = found.lstat()
        if status.st_uid not in _trusted():
            return f"{found} belongs to {_name(status.st_uid)}"
        if not stat.S_ISLNK(status.st_mode):
            place = found
            continue
        links += 1
        if links > MOST_LINKS:
            return f"{folder} has too many links"
        target = found.readlink()
        place = Path(target.anchor) if target.is_absolute() else place
        rest.extend(reversed(target.parts[1:] if target.is_absolute() else target.parts))
    status = place.lstat()
    if status.st_uid not in _trusted():
        return f"{place} belongs to {_name(status.st_uid)}"
    return f"others may write to {place}" if _others_write(status) else ""


def is_trusted(status: os.stat_result) -> bool:
    """Whether an open file is an ordinary one of somebody trusted, and nobody else may write to it."""
    return stat.S_ISREG(status.st_mode) and status.st_uid in _trusted() and not _others_write(status)


def _others_write(status: os.stat_result) -> bool:
    """Whether others may write; a group of one's own, as many systems give one to everybody, is not others."""
    group = bool(status.st_mode & stat.S_IWGRP) and not _is_own(status.st_gid)
    return group or bool(status.st_mode & stat.S_IWOTH)


@cache
def _trusted() -> frozenset[int]:
    """Users who may do anything here anyway."""
    return frozenset({0, os.getuid(), Path("/").stat().st_uid})


@cache
def _is_own(group: int) -> bool:
    """Whether a group is that of one's own name, with nobody else in it."""
    try:
        me, found = pwd.getpwuid(os.getuid()).pw_name, grp.getgrgid(group)
    except KeyError:
        return False
    return found.gr_name == me and set(found.gr_mem) <= {me}


def _name(user: int) -> str:
    """A user's name, or number."""
    try:
        return pwd.getpwuid(user).pw_name
    except KeyError:
        return f"user {user}"
