"""`hotlap plan RACE`: the minimum-time reference, its segments, and files of it for others."""

from __future__ import annotations

import shutil
from argparse import Namespace
from collections.abc import Iterator
from typing import Any

import numpy as np
from rich.text import Text

from hotlap.cli.inputs import PICTURES, check_source, check_target
from hotlap.cli.output import Line, facts, present, seconds, table, working
from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare
from hotlap.planning.reference_csv import save_reference
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentationRule
from hotlap.report.map import draw_map

WIDEST = 100  # columns of a map


def run(options: Namespace) -> int:
    """Plan, or read a reference; write what is asked for."""
    check_target(options.out)
    check_target(options.picture, PICTURES)
    check_source(options.reference)
    race = load_race(options.race)
    with working(f"planning {race.name}" if options.reference is None else f"reading {options.reference}"):
        scenario = prepare(race, options.reference, cache=not options.no_cache, segments=SegmentationRule(options.segments))
    if options.out is not None:
        save_reference(options.out, scenario.reference)
    if options.picture is not None:
        from hotlap.report.pictures import draw_plan  # noqa: PLC0415  matplotlib, only where there is something to draw

        draw_plan(options.picture, scenario)
    files = {"csv": options.out, "picture": options.picture}
    document = {**describe(scenario), **{kind: str(path) for kind, path in files.items() if path is not None}}
    present(as_json=options.json, document=document, lines=[*_lines(scenario), *_written(options)])
    return 0


def describe(scenario: Scenario) -> dict[str, Any]:
    """The keys of `hotlap plan --json`."""
    reference, pieces = scenario.reference, scenario.segments.pieces
    return {
        "race": scenario.race.name,
        "duration": float(reference.duration),
        "lap_time": reference.lap_time,
        "max_speed": float(reference.speeds.max()),
        "mean_speed": float(reference.speeds.mean()),
        "cpu_time": float(reference.cpu_time),
        "gates": len(reference.gate_times),
        "segments": [{"class": piece.kind, "start": piece.start, "end": piece.end, "segment": piece.segment} for piece in pieces],
    }


def _lines(scenario: Scenario) -> Iterator[Line]:
    """For people: figures, segments, and a map."""
    reference = scenario.reference
    yield f"{scenario.race.name}: {len(reference.gate_times)} gates in {seconds(reference.lap_time)}"
    yield from facts(
        {
            "duration": seconds(reference.duration),
            "lap time": seconds(reference.lap_time),
            "top speed": f"{reference.speeds.max():.1f} m/s",
            "mean speed": f"{reference.speeds.mean():.1f} m/s",
            "planned in": f"{reference.cpu_time:.1f} s of processor time" if reference.cpu_time else "",
        }
    )
    yield from table(_cells(scenario), right=(1, 2, 3, 4), indent="  ")
    yield from _map(scenario)


def _cells(scenario: Scenario) -> list[tuple[str, ...]]:
    """A row for each piece; where segments have several, with the number of its segment, as in the map."""
    segments = scenario.segments
    gates = np.bincount(segments.piece_at(scenario.reference.gate_times), minlength=len(segments.classes)).tolist()
    cells = [("segment", "start", "end", "gates", "no.")]
    for piece, count in zip(segments.pieces, gates, strict=True):
        cells.append((str(piece.kind), f"{piece.start:.2f}", f"{piece.end:.2f}", str(count), str(piece.segment + 1)))
    return cells if segments.owners else [row[:-1] for row in cells]


def _map(scenario: Scenario) -> Iterator[Line]:
    """The track from above and from the side, as wide as the terminal is."""
    width = min(shutil.get_terminal_size().columns, WIDEST)
    gates, segments = scenario.race.track.gate_positions, scenario.segments
    yield from Text.from_ansi(draw_map(scenario.reference, gates, segments, width=width, height=width // 4, colour=True)).split()


def _written(options: Namespace) -> Iterator[Line]:
    """What was written where."""
    if options.out is not None:
        yield f"reference written to {options.out}"
    if options.picture is not None:
        yield f"picture written to {options.picture}"
