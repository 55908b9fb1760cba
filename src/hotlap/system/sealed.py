"""Sealed files: what is kept between runs, read only as it was written.

A digest of the content and of the file's name stands at its end: a file that is damaged, or that lies in another's place, is not read but
made anew, and one line says so. Links are not followed, and only ordinary files that nobody else may write to are read, of one's own or of
root. A file that cannot be opened or read at the moment counts as none, and stays.
The digest guards against accidents, and the folder (`system/ownership.py`) against others; neither guards against its owner.
"""

from __future__ import annotations

import errno
import hashlib
import os
import warnings
from contextlib import suppress
from pathlib import Path

from hotlap.system.ownership import is_trusted, make_private
from hotlap.system.regular_files import read_at_most
from hotlap.system.whole_files import new_part, remove_abandoned

MARK, DIGEST = b"hotlap1\n", 32  # what a seal begins with, behind the content; bytes of the digest
SEAL = len(MARK) + DIGEST
LARGEST = 1 << 28  # bytes; what hotlap keeps is a hundredth of it
ABANDONED = "tmp*.part"  # as earlier versions have called what they were about to keep
LOOK = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC


class CacheWarning(UserWarning):
    """Something that was kept cannot be used, and is made anew."""


def read(path: Path) -> bytes | None:
    """What was kept in a file, None where there is none; one that cannot be trusted is removed, and a warning says so, once."""
    try:
        descriptor = os.open(path, LOOK)
    except OSError as error:
        if error.errno == errno.ELOOP:
            reject(path, "is no ordinary file")
        return None
    try:
        trusted = is_trusted(os.fstat(descriptor))
        whole = read_at_most(descriptor, LARGEST) if trusted else b""
    except OSError:
        return None
    finally:
        os.close(descriptor)
    content = whole[:-SEAL]
    if not trusted:
        reject(path, "is not yours alone")
    elif len(whole) > LARGEST or whole[-SEAL:] != _seal(path, content):
        reject(path, "is damaged")
    else:
        return content
    return None


def write(path: Path, content: bytes) -> bool:
    """Keep something, whole or not at all, where only its owner can read it; one that cannot be kept is no error.

    There is no wait for the disk: what a power failure leaves half-written has no seal.

    Returns:
        Whether it is kept.
    """
    with suppress(OSError):
        make_private(path.parent)
        remove_abandoned(path.parent, ABANDONED)
        part = new_part(path.parent, 0o600)
        try:
            part.write_bytes(content + _seal(path, content))
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
        return True
    return False


def reject(path: Path, why: str) -> None:
    """Remove a file that cannot be used; of several processes that find it, the one that removes it says so."""
    try:
        path.unlink()
    except FileNotFoundError:
        return
    except OSError:  # a folder, or one that is only read
        pass
    warnings.warn(f"{path}: {why}, so it is made anew", CacheWarning, stacklevel=3)


def _seal(path: Path, content: bytes) -> bytes:
    """The end of a file of this name with this content."""
    digest = hashlib.blake2b(content, digest_size=DIGEST)
    digest.update(b"\0" + os.fsencode(path.parent.name) + b"/" + os.fsencode(path.name))
    return MARK + digest.digest()
