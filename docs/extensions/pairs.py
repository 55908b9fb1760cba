"""Pairs: numbers of one cell, `100 / 3` and `[86, 95]`, stay on one line however narrow a table gets."""

from __future__ import annotations

import re

from sphinx.application import Sphinx

PAIR = re.compile(r"(?<=[\d\]-]) / (?=[\d-])")
INTERVAL = re.compile(r"(?<=[\d-]), (?=[\d-][\d.]*\])")
SPACE = "\u00a0"  # no line breaks here


def keep(_: Sphinx, __: str, source: list[str]) -> None:
    """Tie the pairs in rows of tables."""
    lines = source[0].split("\n")
    source[0] = "\n".join(tie(line) if line.startswith("|") else line for line in lines)


def tie(row: str) -> str:
    """A row whose pairs and intervals do not break."""
    return INTERVAL.sub(f",{SPACE}", PAIR.sub(f"{SPACE}/{SPACE}", row))


def setup(app: Sphinx) -> dict[str, bool]:
    """Change pages as they are read."""
    app.connect("source-read", keep)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
