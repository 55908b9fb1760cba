"""Exporting: the call `export`; imports nothing that takes time before it is called."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from hotlap.api.asked import Asked

if TYPE_CHECKING:
    from hotlap.api.exported import ExportedFiles
    from hotlap.api.progress import Progress


def export(
    folder: str | Path,
    format: str,  # noqa: A002  the option's name, which nobody would look for under another
    *,
    out: str | Path | None = None,
    progress: Progress | bool | None = None,
) -> ExportedFiles:
    """Write a study's parameters, or its flights, in the files of other programs: all that `hotlap export` does.

    Args:
        folder: folder of a study, as hotlap tune made it.
        format: of which program.
        out: file to write; None: one in DIR.
        progress: receives messages about the progress of the work; True: bars or lines; False: nothing; None: bars in a notebook.

    Returns:
        The files that were written.

    Raises:
        InputError: something that was given is not usable, or the study has not ended.
    """
    asked = Asked(export, locals())
    from hotlap.api.exported import carry_out  # noqa: PLC0415  it loads what reads a study

    return carry_out(asked)
