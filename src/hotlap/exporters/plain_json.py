"""JSON: the same keys as the parameters file."""

from __future__ import annotations

import json
from pathlib import Path

from hotlap.exporters.tuned import read_tuned
from hotlap.study.study import Study
from hotlap.system.text_files import replace


def write(study: Study, path: Path) -> tuple[Path, ...]:
    """Write the parameters with their provenance."""
    replace(path, json.dumps(read_tuned(study).saved.to_table(), indent=2, allow_nan=False) + "\n")
    return (path,)
