"""Kept: what the disk cache holds of each kind of result, and how to remove it."""

from __future__ import annotations

import shutil
import stat
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass

from hotlap.system.disk_cache import folder

KINDS: Mapping[str, str] = {  # each lies in a folder of its name
    "plans": "planned references",
    "kernels": "compiled code of the flight core",
    "digests": "fingerprints of hotlap's own code",
    "betaflight": "what runs the Betaflight firmware",
}


@dataclass(frozen=True)
class Kept:
    """What is kept of a kind.

    Attributes:
        kind: of `KINDS`.
        files: how many.
        size: [bytes] of them.
    """

    kind: str
    files: int
    size: int


def kept() -> tuple[Kept, ...]:
    """What is kept of each kind."""
    return tuple(_measure(kind) for kind in KINDS)


def clear() -> None:
    """Remove what is kept, and nothing else that may lie beside it.

    Raises:
        OSError: something of it cannot be removed.
    """
    for kind in KINDS:
        if folder(kind).is_dir():
            shutil.rmtree(folder(kind))


def _measure(kind: str) -> Kept:
    """Count files and bytes; what goes away meanwhile does not count."""
    sizes = list[int]()
    for path in folder(kind).rglob("*"):
        with suppress(OSError):
            status = path.lstat()
            if not stat.S_ISDIR(status.st_mode):
                sizes.append(status.st_size)
    return Kept(kind, len(sizes), sum(sizes))
