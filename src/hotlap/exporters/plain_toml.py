"""The parameters file itself, as `hotlap fly --parameters` reads it."""

from __future__ import annotations

from pathlib import Path

from hotlap.exporters.tuned import read_tuned
from hotlap.files.descriptions import save_parameters
from hotlap.study.study import Study


def write(study: Study, path: Path) -> tuple[Path, ...]:
    """Write the parameters with their provenance."""
    save_parameters(path, read_tuned(study).saved)
    return (path,)
