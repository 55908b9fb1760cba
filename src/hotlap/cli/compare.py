"""`hotlap compare RACE...`: tuners on equal terms: same first guess, budget, seeds and noise."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterator

from hotlap.analysis.comparison_table import cells_of, held_cells_of
from hotlap.analysis.paired import paired_cells
from hotlap.api.compared import ComparisonResult
from hotlap.api.comparing import compare
from hotlap.cli.options import arguments_of
from hotlap.cli.output import Line, present, table
from hotlap.cli.progress import TERMINAL


def run(options: Namespace) -> int:
    """Fly what is missing, and say how the tuners did."""
    options.races = [*(options.races or ()), *([options.suite] if options.suite else ())]
    compared = compare(**arguments_of(compare, options), progress=TERMINAL)
    present(as_json=options.json, document=compared.to_dict(), lines=_lines(compared))
    return 0


def _lines(compared: ComparisonResult) -> Iterator[Line]:
    """Both tables, and what is where."""
    for rows in (compared.by_race, compared.overall):
        cells = cells_of(rows)
        yield from table(cells, right=range(2, len(cells[0])))
        yield ""
    best = compared.overall[0].tuner
    against = paired_cells([row for row in compared.paired if row.tuner == best])
    if against:
        yield "the best against each other one, race by race and seed by seed; in brackets 95 % intervals, p corrected for their number"
        yield from table(against, right=range(2, len(against[0])))
        yield ""
    for held in filter(None, map(held_cells_of, (compared.by_race, compared.overall))):
        yield "will it hold?"
        yield from table(held, right=range(2, len(held[0])))
        yield ""
    yield str(compared.table)
    if compared.page is not None:
        yield str(compared.page)
    yield from map(str, compared.pictures)
