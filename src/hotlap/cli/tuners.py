"""`hotlap tuners`: the algorithms with their presets."""

from __future__ import annotations

from argparse import Namespace
from importlib import import_module
from typing import Any

from hotlap import tuners
from hotlap.cli.listing import chosen, described, shorten
from hotlap.cli.output import present, table

HEADER = ("tuner", "presets, the default first", "what it is")
LONGEST = 80  # characters of what a tuner is
WIDE = 60  # characters of presets
HINT = "* what hotlap tune takes by itself; --tuner NAME or NAME:PRESET"


def run(options: Namespace) -> int:
    """List them; what is asked for is an algorithm, or any of its presets."""
    presets: dict[str, list[str]] = {}
    for name in tuners.names():
        algorithm, _, preset = name.partition(":")
        presets.setdefault(algorithm, []).append(preset)
    asked = chosen(options.names, (*presets, *tuners.names()), "tuner", {})
    rows = [
        _row(algorithm, [preset for preset in own if algorithm in asked or f"{algorithm}:{preset}" in asked])
        for algorithm, own in presets.items()
    ]
    rows = [row for row in rows if row["presets"]]
    lines = table([HEADER, *map(_cells, rows)])
    present(as_json=options.json, document={"tuners": rows}, lines=[*lines, "", HINT])
    return 0


def _row(algorithm: str, presets: list[str]) -> dict[str, Any]:
    """What is worth knowing about an algorithm at a glance."""
    what = described(import_module(f"{tuners.__name__}.{algorithm}").__doc__)
    return {"name": algorithm, "default": algorithm == tuners.DEFAULT, "presets": presets, "what": what}


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    """A row for people: as many presets as fit."""
    presets = ", ".join(row["presets"])
    shown = presets if len(presets) <= WIDE else presets[: WIDE - 4].rpartition(",")[0] + ", ..."
    return row["name"] + " *" * row["default"], shown, shorten(row["what"], LONGEST)
