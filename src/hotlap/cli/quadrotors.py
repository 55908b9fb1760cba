"""`hotlap quadrotors`: the built-in quadrotors."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

from hotlap.cli.listing import chosen, shorten, show
from hotlap.cli.output import present, table
from hotlap.files.descriptions import Kind, load_quadrotor, load_race, names

HEADER = ("quadrotor", "mass kg", "thrust/weight", "arm m", "dead time", "races", "provenance")


def run(options: Namespace) -> int:
    """List them."""
    flown: dict[str, list[str]] = {}
    for race in names(Kind.RACE):
        flown.setdefault(load_race(race).vehicle.name, []).append(race)
    rows = [_row(name, flown) for name in chosen(options.names, names(Kind.QUADROTOR), "quadrotor", {})]
    present(as_json=options.json, document={"quadrotors": rows}, lines=table([HEADER, *map(_cells, rows)], right=(1, 2, 3, 4, 5)))
    return 0


def _row(name: str, flown: dict[str, list[str]]) -> dict[str, Any]:
    """What is worth knowing about a quadrotor at a glance."""
    vehicle = load_quadrotor(name)
    return {
        "name": name,
        "mass": vehicle.mass,
        "thrust_to_weight": vehicle.thrust_to_weight,
        "arm": vehicle.arm,
        "delay": vehicle.delay,
        "races": flown.get(vehicle.name, []),
        "provenance": vehicle.provenance,
    }


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    """A row for people; `races` counts those that it flies."""
    mass, ratio, delay = show(row["mass"]), f"{row['thrust_to_weight']:.2f}", f"{1e3 * row['delay']:.0f} ms"
    return row["name"], mass, ratio, show(row["arm"]), delay, str(len(row["races"])), shorten(row["provenance"])
