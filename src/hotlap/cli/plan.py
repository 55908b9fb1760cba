"""`hotlap plan RACE`: the minimum-time reference, its segments, and files of it for others."""

from __future__ import annotations

import shutil
from argparse import Namespace
from collections.abc import Iterator

import numpy as np
from rich.text import Text

from hotlap.api.planned import PlannedReference
from hotlap.api.planning import plan
from hotlap.api.wording import seconds
from hotlap.cli.options import arguments_of
from hotlap.cli.output import Line, facts, present, table
from hotlap.cli.progress import TERMINAL
from hotlap.core.counts import count
from hotlap.reference.scenario import Scenario
from hotlap.report.map import draw_map
from hotlap.report.structures import structures_of

WIDEST = 100  # columns of a map


def run(options: Namespace) -> int:
    """Plan, or read a reference; write what is asked for."""
    planned = plan(**arguments_of(plan, options), progress=TERMINAL)
    present(as_json=options.json, document=planned.to_dict(), lines=_lines(planned))
    return 0


def _lines(planned: PlannedReference) -> Iterator[Line]:
    """For people: figures, segments, a map, and what was written where."""
    scenario, reference = planned.scenario, planned.reference
    yield f"{scenario.race.name}: {count(len(reference.gate_times), 'gate')} in {seconds(reference.lap_time)}"
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
    yield from (f"{kind} written to {path}" for kind, path in (("reference", planned.csv), ("picture", planned.picture)) if path)


def _cells(scenario: Scenario) -> list[tuple[str, ...]]:
    """A row for each piece; where segments have several, with the number of its segment, as in the map."""
    segments = scenario.segments
    gates = np.bincount(segments.piece_at(scenario.reference.gate_times), minlength=len(segments.classes)).tolist()
    cells = [("segment", "start", "end", "gates", "no.")]
    for piece, passed in zip(segments.pieces, gates, strict=True):
        cells.append((str(piece.kind), f"{piece.start:.2f}", f"{piece.end:.2f}", str(passed), str(piece.segment + 1)))
    return cells if segments.owners else [row[:-1] for row in cells]


def _map(scenario: Scenario) -> Iterator[Line]:
    """The track from above and from the side, as wide as the terminal is."""
    width = min(shutil.get_terminal_size().columns, WIDEST)
    race, segments = scenario.race, scenario.segments
    gates, standing = race.track.gate_positions, structures_of(race.track, race.judge.distance)
    drawn = draw_map(scenario.reference, gates, segments, structures=standing, width=width, height=width // 4, colour=True)
    yield from Text.from_ansi(drawn).split()
