"""The parameters file itself, as `hotlap fly --parameters` reads it, with what the controller flew with."""

from __future__ import annotations

from pathlib import Path

from hotlap.exporters.flown_with import read_remarked
from hotlap.files.descriptions import save_parameters
from hotlap.study.study import Study


def write(study: Study, path: Path) -> tuple[Path, ...]:
    """Write the parameters with their provenance."""
    save_parameters(path, read_remarked(study))
    return (path,)
