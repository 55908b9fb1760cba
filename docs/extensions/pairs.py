"""Pairs: numbers of one cell, `100 / 3`, stay on one line however narrow a table gets."""

from __future__ import annotations

import re

from sphinx.application import Sphinx

PAIR = re.compile(r"(?<=[\d-]) / (?=[\d-])")
NARROW = "\u00a0/\u00a0"  # no line breaks here


def keep(_: Sphinx, __: str, source: list[str]) -> None:
    """Tie the pairs in rows of tables."""
    lines = source[0].split("\n")
    source[0] = "\n".join(PAIR.sub(NARROW, line) if line.startswith("|") else line for line in lines)


def setup(app: Sphinx) -> dict[str, bool]:
    """Change pages as they are read."""
    app.connect("source-read", keep)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
