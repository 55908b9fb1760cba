"""Export: tuned parameters in the files that other programs read; one file of code a format.

Each format is a function `write(study, path) -> paths` that overwrites what is there, and loads what it needs when it is called.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from hotlap.core.errors import UnknownNameError
from hotlap.exporters.formats import FORMATS, Format

if TYPE_CHECKING:
    from hotlap.study.study import Study


def export(study: Study, name: str, path: Path | None = None) -> tuple[Path, ...]:
    """Write a study's parameters, or its flights, as others read them.

    Args:
        study: open to read.
        name: of the format.
        path: where; None: the format's own name in the study's folder.

    Returns:
        The files that were written.

    Raises:
        InputError: the format is unknown or cannot hold these parameters, the study has not ended, a file cannot be written.
    """
    if name not in FORMATS:
        raise UnknownNameError("format", name, FORMATS, key="format")
    chosen = FORMATS[name]
    target = study.folder / chosen.file if path is None else path
    return import_module(f"hotlap.exporters.{chosen.module}").write(study, target)


__all__ = ["FORMATS", "Format", "export"]
