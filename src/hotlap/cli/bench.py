"""`hotlap bench`: how fast the flight core flies on this machine."""

from __future__ import annotations

from argparse import Namespace

from hotlap.analysis.speed import STAGES, measure
from hotlap.cli.output import present
from hotlap.cli.progress import follow_stages


def run(options: Namespace) -> int:
    """Measure, and say what was measured."""
    with follow_stages(STAGES) as say:
        bench = measure(say)
    present(as_json=options.json, document=bench.dump(), lines=bench.lines())
    return 0
