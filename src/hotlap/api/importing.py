"""Importing: the call `import_file`; imports nothing that takes time before it is called."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from hotlap.api.asked import Asked

if TYPE_CHECKING:
    from hotlap.importers.imported import Imported


def import_file(file: str | Path, *, out: Path | str | None = None, name: str | None = None) -> tuple[Imported, Path]:
    """Write a track or quadrotor of another program as a file of hotlap: all that `hotlap import` does.

    Args:
        file: a file of another program, or airsim://HOST:PORT for the gates of the level that AirSim runs there.
        out: file to write, a new one; None: NAME.toml.
        name: what it is called; which vehicle, where the file has several; None: as in FILE.

    Returns:
        What was read, with what was assumed and left out, and the file that was written.

    Raises:
        InputError: the file cannot be read, says what cannot be, or would be written over another.
    """
    asked = Asked(import_file, locals())
    from hotlap.api.imported import carry_out  # noqa: PLC0415  it loads what reads files

    return carry_out(asked)
