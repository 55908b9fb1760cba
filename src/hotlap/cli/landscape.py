"""`hotlap landscape RACE`: completion as a map over two parameters."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.analysis.landscape import Landscape, axes, survey
from hotlap.api.inputs import check_range, check_source, check_target
from hotlap.api.scenarios import check_guess
from hotlap.api.wording import percent
from hotlap.cli.flying import load, make_ready, read_guess
from hotlap.cli.output import facts, note, present, working
from hotlap.cli.progress import follow_pieces
from hotlap.core.counts import count
from hotlap.core.errors import UnknownNameError
from hotlap.planning.preparation import prepare
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentationRule
from hotlap.report.formats import SUFFIXES
from hotlap.system.engine import Engine, opened
from hotlap.worlds.built_in import BuiltIn

Floats = NDArray[np.float64]

MOST_POINTS, MOST_FLIGHTS = 500, 100


def run(options: Namespace) -> int:
    """Fly the map, and draw it."""
    check_range("points", options.points, 2, MOST_POINTS)
    check_range("flights", options.flights, 1, MOST_FLIGHTS)
    check_target(options.out, SUFFIXES)
    check_source(options.reference)
    check_guess(options.first_guess)
    if options.cluster is None:
        return _run(options, None)
    with opened(options.cluster, note=note) as engine:
        return _run(options, engine)


def _run(options: Namespace, engine: Engine | None) -> int:
    """The same, with workers of an engine; None: in this process."""
    race, world = load(options), BuiltIn()
    with working(f"planning {race.name}" if options.reference is None else f"reading {options.reference}"):
        scenario = prepare(race, options.reference, segments=SegmentationRule.NONE)
    for remark in scenario.notes:
        note(f"note: {remark}")
    names = scenario.space.names
    for option, name in (("x", options.x), ("y", options.y)):
        if name not in names:
            raise UnknownNameError("parameter", name, names, key=option)
    held = tuple(read_guess(options.first_guess, scenario)[0].tolist())
    wanted = Landscape(race, options.x, options.y, options.points, options.flights, held)
    make_ready(world, scenario)
    with follow_pieces(f"rows of {count(options.points * options.flights, 'flight')}", options.points, 0) as say:
        grid = survey(scenario, world, wanted, say, engine)
    middle = dict(zip(names, held, strict=True))
    if options.out is not None:
        from hotlap.report.reproduction import draw_maps  # noqa: PLC0415  matplotlib takes half a second to load

        title = f"{race.name}: {percent(float((grid == 1).mean()))} of the map complete"
        draw_maps(options.out, axes(scenario, wanted), (options.x, options.y), [grid], [title], (middle[options.x], middle[options.y]))
    document, lines = _words(options, scenario, wanted, grid)
    present(as_json=options.json, document=document, lines=lines)
    return 0


def _words(options: Namespace, scenario: Scenario, wanted: Landscape, grid: Floats) -> tuple[dict[str, Any], list[str]]:
    """The map as JSON, and what it shows in lines.

    Args:
        options: of the command.
        scenario: that was flown.
        wanted: what the map is of.
        grid: shape (points, points) completion [-], y by x.
    """
    race, (x, y) = scenario.race, axes(scenario, wanted)
    best = np.unravel_index(int(np.argmax(grid)), grid.shape)
    document = {
        "race": race.name,
        "notes": list(scenario.notes),
        "x": options.x,
        "y": options.y,
        "x_values": x.tolist(),
        "y_values": y.tolist(),
        "completion": grid.tolist(),
    }
    lines = [
        f"{race.name}: completion over {options.x} and {options.y}, {count(options.flights, 'flight')} at each of {grid.size} points",
        *facts(
            {
                "complete": f"{percent(float((grid == 1).mean()))} of the map",
                "mean": f"{percent(float(grid.mean()))} of the gates",
                "best at": f"{options.x} {x[best[1]]:.3g}, {options.y} {y[best[0]]:.3g}: {percent(float(grid.max()))}",
                "picture": str(options.out or ""),
            }
        ),
    ]
    return document, lines
