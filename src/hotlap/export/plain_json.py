"""JSON: the same keys as the parameters file."""

from __future__ import annotations

import json
from pathlib import Path

from hotlap.export.tuned import read_tuned
from hotlap.files import replace
from hotlap.study import Study


def write(study: Study, path: Path) -> tuple[Path, ...]:
    """Write the parameters with their provenance."""
    replace(path, json.dumps(read_tuned(study).saved.to_table(), indent=2, allow_nan=False) + "\n")
    return (path,)
