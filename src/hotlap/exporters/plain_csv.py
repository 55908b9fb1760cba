"""CSV for tables and plots: one row a segment."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hotlap.exporters.tuned import read_tuned
from hotlap.study.study import Study
from hotlap.system.text_files import replace


def write(study: Study, path: Path) -> tuple[Path, ...]:
    """Write segment, class, start, end [s] and the parameters; starts and ends of several pieces are separated by spaces."""
    saved = read_tuned(study).saved
    columns = ("class", "start", "end", *saved.names)
    rows = [[str(i), *(_cell(row[name]) for name in columns)] for i, row in enumerate(saved.to_table()["segment"])]
    replace(path, "".join(",".join(row) + "\n" for row in (["segment", *columns], *rows)))
    return (path,)


def _cell(value: Any) -> str:
    """A number bit for bit, a word, or several numbers."""
    if isinstance(value, list):
        return " ".join(map(repr, value))
    return value if isinstance(value, str) else repr(value)
