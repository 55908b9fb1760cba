"""`hotlap score LOG --race RACE`: a flight that really happened, judged beside simulated ones."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterator

from hotlap.api.scored import ScoredFlight
from hotlap.api.scoring import score
from hotlap.cli.options import arguments_of
from hotlap.cli.output import Line, present, table
from hotlap.cli.progress import TERMINAL


def run(options: Namespace) -> int:
    """Judge it, and say how it went; a drone that crashed is a result, not a failure."""
    scored = score(**arguments_of(score, options), progress=TERMINAL)
    present(as_json=options.json, document=scored.to_dict(), lines=_lines(scored))
    return 0


def _lines(scored: ScoredFlight) -> Iterator[Line]:
    """What was measured, and what was assumed."""
    known = scored.facts()
    yield known["race"]
    yield from table([("", "flown", "simulated"), *scored.figures()], indent="  ")
    yield f"  {known['time and frame']}"
    yield from (f"  note: {note}" for note in scored.notes)
    if scored.page is not None:
        yield str(scored.page)
