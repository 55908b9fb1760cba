"""Soak: a million flights, and ten thousand tunings, in one process each: python benchmarks/soak.py --help

A process that leaks or slows down does so by little each time. Flights are flown in batches with seeds of their own, tunings one after the
other; now and then one line tells the memory that is resident, the open files and the rate since the last line, in time of the processors.
At the end the first flights, or the first tuning, are done again and must give the same bits. It fails where memory or rate of the last
half are more than 5 % worse than those of the half before, or a file is left open. Linux and macOS.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median

import numpy as np

from hotlap import tuners
from hotlap.core.version import __version__
from hotlap.planning.preparation import prepare
from hotlap.tuning.loop import Tuning, TuningSettings, tune
from hotlap.tuning.objective import Objective
from hotlap.worlds.built_in import BuiltIn

BATCH = 500  # flights at once
LINES = 20  # of a soak
WORSE = 0.05  # share by which memory and rate may get worse


@dataclass(frozen=True)
class Reading:
    """What a process has at one moment.

    Attributes:
        done: flights or tunings so far.
        memory: resident [MB].
        files: open.
        rate: flights or tunings a second of the processors since the last reading.
        wall: [s] since the beginning.
    """

    done: int
    memory: float
    files: int
    rate: float
    wall: float


def memory() -> float:
    """Resident memory [MB]; where there is no /proc, the most there ever was."""
    try:
        return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
    except FileNotFoundError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6


def soak(do: Callable[[int], bytes], count: int, step: int) -> Iterator[Reading]:
    """Do something over and over.

    Args:
        do: what is done, from a number on; the bits of its result.
        count: how much of it.
        step: how much is done at once.

    Raises:
        SystemExit: the first result is another at the end.
    """
    first = do(0)
    begun, processor, last = time.monotonic(), time.process_time(), 0
    for done in range(step, count + step, step):
        do(done)
        if done - last >= count // LINES:
            now = time.process_time()
            yield Reading(done, memory(), len(list(Path("/dev/fd").iterdir())), (done - last) / (now - processor), time.monotonic() - begun)
            processor, last = time.process_time(), done
    if do(0) != first:
        sys.exit("the first result is another at the end")


def verdict(readings: Sequence[Reading]) -> str:
    """What got worse, "" where nothing did: the last half beside the first, whose first reading does not count: things are loaded then."""
    before, last = readings[1 : (len(readings) + 1) // 2], readings[(len(readings) + 1) // 2 :]
    told = []
    if max(one.memory for one in last) > (1 + WORSE) * max(one.memory for one in before):
        told.append("memory grows")
    if max(one.files for one in last) > max(one.files for one in before):
        told.append("files are left open")
    if median(one.rate for one in last) < (1 - WORSE) * median(one.rate for one in before):
        told.append("it slows down")
    return ", ".join(told)


def flights(race: str) -> Callable[[int], bytes]:
    """Flies a batch of a race with seeds from a number on."""
    world, scenario = BuiltIn(), prepare(race)
    parameters = np.repeat(scenario.space.first_guess(len(scenario.segments))[None], BATCH, axis=0)

    def fly(start: int) -> bytes:
        flown = world.fly(scenario, parameters, np.arange(start, start + BATCH))
        return b"".join(np.ascontiguousarray(values).tobytes() for values in (flown.end_time, flown.gate_times))

    return fly


def tunings(race: str) -> Callable[[int], bytes]:
    """Tunes a race with a seed; tuners take turns."""
    objective = Objective(prepare(race), BuiltIn())
    kinds = ("gate_gp", "metropolis_hastings", "random_search", "cma_es")

    def run(seed: int) -> bytes:
        tuning = Tuning(
            tuners.build(kinds[seed % len(kinds)]), objective.scenario, TuningSettings(budget=30, seed=seed, validation=0, selection=0)
        )
        return b"".join(batch.ledger.parameters.tobytes() + batch.ledger.cost.tobytes() for batch in tune(objective, tuning))

    return run


def main() -> None:
    """Soak, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("flights", "tunings"))
    parser.add_argument("--race", default="circle-34")
    parser.add_argument("--count", type=int, default=0, help="default: 1 000 000 flights, 10 000 tunings")
    parser.add_argument("--out", type=Path, help="a JSON file for the readings")
    asked = parser.parse_args()
    do, count, step = (flights, 1_000_000, BATCH) if asked.what == "flights" else (tunings, 10_000, 1)
    count = asked.count or count
    readings = list[Reading]()
    print(f"| {asked.what} | memory, MB | open files | a second of a processor | wall, s |\n|---:|---:|---:|---:|---:|")
    for reading in soak(do(asked.race), count, step):
        readings.append(reading)
        cells = f"{reading.done} | {reading.memory:.0f} | {reading.files} | {reading.rate:.1f} | {reading.wall:.0f}"
        print(f"| {cells} |", flush=True)
    print("the first result is the same at the end, bit for bit")
    if asked.out:
        document = {"hotlap": __version__, "what": asked.what, "race": asked.race, "readings": [asdict(one) for one in readings]}
        asked.out.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    sys.exit(verdict(readings) or 0)


if __name__ == "__main__":
    main()
