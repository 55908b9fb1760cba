"""JSON: the same keys as the parameters file, and what the controller flew with."""

from __future__ import annotations

import json
from pathlib import Path

from hotlap.exporters.flown_with import read_remarked
from hotlap.study.study import Study
from hotlap.system.text_files import replace


def write(study: Study, path: Path) -> tuple[Path, ...]:
    """Write the parameters with their provenance."""
    replace(path, json.dumps(read_remarked(study).to_table(), indent=2, allow_nan=False) + "\n")
    return (path,)
