"""`hotlap transfer DIR`: parameters of a study in other worlds than the one that they were tuned in."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterator

from hotlap.api.transferred import TransferResult
from hotlap.api.transferring import transfer
from hotlap.cli.options import arguments_of
from hotlap.cli.output import Line, present, table
from hotlap.cli.progress import TERMINAL
from hotlap.report.transfer_article import HEADS, cells_of, changes, endings


def run(options: Namespace) -> int:
    """Fly what is missing, and say how it went; drones that crash are a result, not a failure."""
    flown = transfer(**arguments_of(transfer, options), progress=TERMINAL)
    present(as_json=options.json, document=flown.to_dict(), lines=_lines(flown))
    return 0


def _lines(flown: TransferResult) -> Iterator[Line]:
    """The table, what changed by tuning, and what is where."""
    rows = flown.by_world
    yield f"{flown.scenario.race.name}: tuned in {flown.worlds[0]}"
    yield from table([HEADS, *cells_of(rows)], right=[len(HEADS) - 1], indent="  ")
    yield from changes(rows)
    yield from (f"  {world}, {label}: {ended}" for world, label, ended in endings(rows))
    if flown.page is not None:
        yield str(flown.page)
    yield from map(str, flown.pictures)
