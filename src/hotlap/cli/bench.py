"""`hotlap bench`: how fast the flight core flies on this machine."""

from __future__ import annotations

from argparse import Namespace

from hotlap.bench import measure
from hotlap.cli.output import note, present


def run(options: Namespace) -> int:
    """Measure, and say what was measured."""
    bench = measure(note)
    present(as_json=options.json, document=bench.dump(), lines=bench.lines())
    return 0
