"""Drive: what holds files when the power is gone."""

from __future__ import annotations

import fcntl
import os
from contextlib import suppress

FULL = getattr(fcntl, "F_FULLFSYNC", None)  # macOS alone has it; `fsync` there leaves what is written in the drive's own memory


def flush(descriptor: int) -> None:
    """Have the drive hold a file, or a folder, for good.

    Where a file system cannot empty the memory of its drive, as some over a network, it is `fsync`.

    Raises:
        OSError: it cannot be written.
    """
    if FULL is not None:
        with suppress(OSError):
            fcntl.fcntl(descriptor, FULL)
            return
    os.fsync(descriptor)
