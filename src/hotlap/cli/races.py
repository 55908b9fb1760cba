"""`hotlap races`: the built-in races and what to expect of them."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

from hotlap.cli.output import present, table
from hotlap.files.descriptions import Kind, load_race, names
from hotlap.planning.feasibility import describe_race

HEADER = ("race", "track", "gates", "v_max", "vehicle", "rule", "expected", "provenance")
LONGEST = 30  # characters of a provenance


def run(options: Namespace) -> int:
    """List them."""
    rows = [_row(name) for name in names(Kind.RACE)]
    cells = [HEADER, *((*map(_show, list(row.values())[:-1]), _shorten(row["provenance"])) for row in rows)]
    present(as_json=options.json, document={"races": rows}, lines=table(cells, right=(2, 3)))
    return 0


def _row(name: str) -> dict[str, Any]:
    """What is worth knowing about a race at a glance."""
    race = load_race(name)
    return {
        "name": name,
        "track": race.track.name,
        "gates": len(race.track.counted),
        "v_max": race.planning.v_max,
        "vehicle": race.vehicle.name,
        "rule": race.judge.rule.value,
        "difficulty": describe_race(race)[-1].value,
        "provenance": race.provenance,
    }


def _show(value: str | float | None) -> str:
    return "-" if value is None else value if isinstance(value, str) else f"{value:g}"


def _shorten(text: str) -> str:
    """The first clause, or as much of it as fits."""
    clause = text.partition(". ")[0].partition("; ")[0].rstrip(".")
    return clause if len(clause) <= LONGEST else clause[: LONGEST - 4].rpartition(" ")[0] + " ..."
