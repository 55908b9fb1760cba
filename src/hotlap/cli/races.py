"""`hotlap races`: the built-in races and what to expect of them."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

from hotlap.cli.output import present, table
from hotlap.feasibility.race import beyond, thrust_share, unknown_latency
from hotlap.files.descriptions import Kind, load_race, names

HEADER = ("race", "track", "gates", "v_max", "vehicle", "rule", "thrust", "latency", "provenance")
LONGEST = 30  # characters of a provenance


def run(options: Namespace) -> int:
    """List them."""
    rows = [_row(name) for name in names(Kind.RACE)]
    present(as_json=options.json, document={"races": rows}, lines=table([HEADER, *map(_cells, rows)], right=(2, 3, 6, 7)))
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
        "difficulty": beyond(race) or None,
        "thrust_share": thrust_share(race),
        "unknown_latency": unknown_latency(race),
        "provenance": race.provenance,
    }


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    """A row for people: the share of its thrust that the plan takes, and the dead time that the controller does not know of."""
    shown = [_show(row[name]) for name in ("name", "track", "gates", "v_max", "vehicle", "rule")]
    return (*shown, f"{row['thrust_share']:.0%}", f"{1e3 * row['unknown_latency']:.0f} ms", _shorten(row["provenance"]))


def _show(value: str | float | None) -> str:
    return "-" if value is None else value if isinstance(value, str) else f"{value:g}"


def _shorten(text: str) -> str:
    """The first clause, or as much of it as fits."""
    clause = text.partition(". ")[0].partition("; ")[0].rstrip(".")
    return clause if len(clause) <= LONGEST else clause[: LONGEST - 4].rpartition(" ")[0] + " ..."
