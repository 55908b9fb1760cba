"""`hotlap lap RACE --on VEHICLE`: a real vehicle, flown once."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterator

from hotlap.api.lapped import LapResult
from hotlap.api.lapping import lap
from hotlap.cli.options import arguments_of
from hotlap.cli.output import Line, facts, present
from hotlap.cli.progress import TERMINAL

FAILURE = 1


def run(options: Namespace) -> int:
    """Fly it, and say how it went; a gate that was missed is a result, a flight that was stopped is a failure."""
    lapped = lap(**arguments_of(lap, options), progress=TERMINAL)
    present(as_json=options.json, document=lapped.to_dict(), lines=_lines(lapped, options.race))
    return FAILURE if lapped.stopped else 0


def _lines(lapped: LapResult, race: str) -> Iterator[Line]:
    """How it went, for people; and how its log is judged in the race that was asked for."""
    title, *_ = known = lapped.facts()
    yield known[title]
    yield from facts({label: value for label, value in known.items() if label != title and value})
    if lapped.log is not None:
        yield f"log written to {lapped.log}"
        if lapped.scores is not None:
            yield f"judge it beside simulated flights: hotlap score {lapped.log} --race {race}"
