"""The long form: `python tests/fuzz/run.py [--inputs N] [--first N] [READER ...]` prints a line of figures for each reader."""

from __future__ import annotations

import argparse
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from fuzz.logs import LOGS
from fuzz.readers import READERS
from fuzz.records import RECORDS
from fuzz.trial import Figures, attempt
from fuzz.wires import WIRES

ALL = {**READERS, **LOGS, **RECORDS, **WIRES}


def measure(name: str, inputs: int, first: int) -> Figures:
    """One reader."""
    with tempfile.TemporaryDirectory(prefix="hotlap-fuzz-") as folder:
        return attempt(name, lambda random: ALL[name].give(random, Path(folder)), inputs, Path(folder), first)


def main() -> int:
    """Run what was asked for; 1 where there was a fault."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("readers", nargs="*", choices=[*ALL, []], default=[], metavar="READER", help=", ".join(ALL))
    parser.add_argument("--inputs", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0)
    asked, faults = parser.parse_args(), 0
    print(f"{'reader':24} {'inputs':>7} {'refused':>8} {'accepted':>8} {'longest':>9} {'memory':>8}  faults")
    for name in asked.readers or ALL:
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as alone:  # so that the memory is its own
            figures = alone.submit(measure, name, asked.inputs, asked.first).result()
        shown = f"{name:24} {figures.inputs:7} {figures.refused:8} {figures.accepted:8} {figures.longest:7.2f} s {figures.memory:5.0f} MB"
        print(f"{shown}  {len(figures.faults)}", flush=True)
        for fault in figures.faults[:3]:
            print(fault)
        faults += len(figures.faults)
    return min(faults, 1)


if __name__ == "__main__":
    sys.exit(main())
