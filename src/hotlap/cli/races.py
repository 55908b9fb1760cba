"""`hotlap races`: the built-in races and what to expect of them."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

from hotlap.cli.listing import chosen, shorten, show
from hotlap.cli.output import present, table
from hotlap.feasibility.race import beyond, thrust_share, unknown_latency
from hotlap.files.descriptions import Kind, load_race, names

HEADER = ("race", "track", "gates", "v_max", "vehicle", "rule", "thrust", "latency", "provenance")


def run(options: Namespace) -> int:
    """List them."""
    rows = [_row(name) for name in chosen(options.names, names(Kind.RACE), "race")]
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
    shown = [show(row[name]) for name in ("name", "track", "gates", "v_max", "vehicle", "rule")]
    return (*shown, f"{row['thrust_share']:.0%}", f"{1e3 * row['unknown_latency']:.0f} ms", shorten(row["provenance"]))
