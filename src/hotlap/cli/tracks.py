"""`hotlap tracks`: the built-in tracks."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

import numpy as np

from hotlap.cli.listing import chosen, shorten, show
from hotlap.cli.output import present, table
from hotlap.files.descriptions import Kind, load_race, load_track, names

HEADER = ("track", "gates", "length m", "height m", "obstacles", "races", "provenance")


def run(options: Namespace) -> int:
    """List them."""
    flown: dict[str, list[str]] = {}
    for race in names(Kind.RACE):
        flown.setdefault(load_race(race).track.name, []).append(race)
    rows = [_row(name, flown) for name in chosen(options.names, names(Kind.TRACK), "track", {})]
    present(as_json=options.json, document={"tracks": rows}, lines=table([HEADER, *map(_cells, rows)], right=(1, 2, 3, 4, 5)))
    return 0


def _row(name: str, flown: dict[str, list[str]]) -> dict[str, Any]:
    """What is worth knowing about a track at a glance."""
    track = load_track(name)
    points = np.vstack([track.start, track.waypoints])
    return {
        "name": name,
        "gates": len(track.counted),
        "length": float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()),
        "height": float(np.ptp(points[:, 2])),
        "obstacles": len(track.poles) + len(track.spheres) + len(track.boxes),
        "races": flown.get(track.name, []),
        "provenance": track.provenance,
    }


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    """A row for people; length and height are those of the straight lines between the gates."""
    rounded = [f"{row[name]:.0f}" for name in ("length", "height")]
    return row["name"], show(row["gates"]), *rounded, show(row["obstacles"]), str(len(row["races"])), shorten(row["provenance"])
