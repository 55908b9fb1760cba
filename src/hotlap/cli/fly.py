"""`hotlap fly RACE`: given parameters once more, with fresh noise."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterator

from hotlap.api.flown import FlightsResult
from hotlap.api.flying import fly
from hotlap.cli.held import show_advice, show_robustness
from hotlap.cli.options import arguments_of
from hotlap.cli.output import Line, facts, present
from hotlap.cli.progress import TERMINAL


def run(options: Namespace) -> int:
    """Fly them, and say how they ended; drones that crash are a result, not a failure."""
    flown = fly(**arguments_of(fly, options), progress=TERMINAL)
    present(as_json=options.json, document=flown.to_dict(), lines=_lines(flown))
    return 0


def _lines(flown: FlightsResult) -> Iterator[Line]:
    """How they ended, for people."""
    title, *_ = known = flown.facts()
    yield known[title]
    yield from facts({label: value for label, value in known.items() if label != title})
    yield from (f"  {line}" for line in flown.ends())
    if flown.robustness:
        yield "will it hold?"
        yield from show_robustness(flown.robustness)
    yield from show_advice(flown.failures, flown.advice)
    if flown.log is not None:
        yield f"log written to {flown.log}"
