"""What a cluster costs, and where it stops scaling: python benchmarks/cluster_scaling.py flights|bytes|tasks|runs|simulate [--out FILE]

    flights    what a flight costs on one thread, by how many are flown together
    bytes      what is sent and received for a piece of work of each kind
    tasks      pieces of no work over one and two workers: pieces a second, and processor time of scheduler, client and worker for each
    runs       a comparison over one and two workers of a cluster, and over processes of this machine
    simulate   the same scheduler with up to 4096 workers, as a queue with the times that `tasks` measured: a model, not a measurement

Each prints a table of Markdown. All but `simulate` measure, on this machine alone; `simulate` takes its times from `--scheduler`,
`--client` and `--bytes`.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from heapq import heappop, heappush
from pathlib import Path
from typing import Any

import numpy as np

from hotlap.analysis.comparison import Cell, fly_cells
from hotlap.analysis.landscape import Landscape, Rows, fly_rows
from hotlap.analysis.learning import Lesson, tune_lesson
from hotlap.analysis.plan_trials import Trial, first_plan_settings, try_plan
from hotlap.files.descriptions import load_race
from hotlap.planning.preparation import prepare
from hotlap.reference.segmentation import SegmentationRule
from hotlap.system import cluster_worker
from hotlap.system.engine import opened
from hotlap.tuning.loop import TuningSettings
from hotlap.worlds.built_in import BuiltIn
from hotlap.worlds.on_workers import Sortie, fly_sortie

RACE = "circle-34"
PAYLOAD = 10_000  # bytes of a piece of no work
AHEAD, FEWEST_AHEAD, HELD = 4, 64, 2  # pieces on the cluster for each worker, at least; on a worker, as dask holds them
NETWORK = 125e6  # bytes/s of the client's link: 1 Gbit/s
WORKERS = (2, 8, 32, 128, 512, 1024, 2048, 4096)
PIECES = (0.1, 1.0, 10.0, 60.0)  # s
PER_WORKER = 20  # pieces, in a simulated sweep
SPREAD = 0.5  # of the natural logarithm of a piece's duration


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Markdown."""
    lines = [head, tuple("---" for _ in head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def flights() -> str:
    """Flights a second on one thread, by how many are flown together."""
    scenario, world = prepare(RACE), BuiltIn(threads=1)
    default = scenario.space.first_guess(len(scenario.segments))
    world.prepare(scenario)
    rows = []
    for together in (1, 4, 16, 64, 256):
        parameters, seeds = np.repeat(default[None], together, axis=0), np.arange(together)
        begun, flown = time.process_time(), 0
        while time.process_time() - begun < 2.0:
            world.fly(scenario, parameters, seeds)
            flown += together
        spent = (time.process_time() - begun) / flown
        rows.append((str(together), f"{1e3 * spent:.2f}", f"{1 / spent:.0f}"))
    return table(("flown together", "ms of a processor for a flight", "flights/s of a worker"), rows)


def sizes() -> str:
    """Bytes of pieces and of their results, and how long they take on one thread."""
    race = load_race(RACE)
    scenario = prepare(race, segments=SegmentationRule.NONE)
    settings = TuningSettings(budget=200, confirm=4, validation=50, reliability=0.0)
    cell = Cell(race, "gate_gp", settings, (0,))
    one = scenario.space.first_guess(len(scenario.segments))[None]
    pieces: dict[str, tuple[Callable[[Any], Any], Any]] = {
        "compare: one run, at most 200 flights": (fly_cells, (cell,)),
        "compare: ten runs, at most 2000 flights": (fly_cells, (Cell(race, "gate_gp", settings, tuple(range(10))),)),
        "landscape: one row of 50 points, 200 flights": (fly_rows, Rows(scenario, Landscape(race, "Q_pos_xy", "horizon"), 0, 1)),
        "learn: one race, at most 900 flights": (tune_lesson, Lesson(race, "hummingbird")),
        "lap-time front: one plan, at most 200 flights": (try_plan, Trial(race, first_plan_settings(race), "gate_gp", settings)),
        "betaflight: one flight": (fly_sortie, Sortie("betaflight", scenario, 0, one, np.zeros(1, dtype=np.int64), ())),
    }
    rows = []
    for name, (work, piece) in pieces.items():
        sent = cluster_worker.pack(work, piece, ())
        cluster_worker.do(sent, cluster_worker.fingerprint())  # kernels and plans are there
        begun = time.perf_counter()
        received = cluster_worker.do(sent, cluster_worker.fingerprint())
        spent = time.perf_counter() - begun
        _, error = cluster_worker.unpack(received)
        if error is not None:
            raise error
        rows.append((name, f"{len(sent):,}", f"{len(received):,}", f"{spent:.2f}"))
    return table(("piece", "bytes sent", "bytes received", "s on one thread"), rows)


def nothing(_: bytes) -> Iterator[int]:
    """No work."""
    yield 1


@contextmanager
def cluster(workers: int) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Scheduler and workers on this machine: the file of the address, and their processes, the scheduler's first."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
        variables = {**os.environ, "PYTHONPATH": path, "DASK_LOGGING__DISTRIBUTED": "critical"}
        dask, file = [sys.executable, "-m", "dask"], Path(folder) / "scheduler.json"
        local = ["--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(file)]
        each = [*dask, "worker", "--no-nanny", "--nthreads", "1", "--local-directory", folder, *local]
        commands = [*dask, "scheduler", "--port", "0", *local], *[each] * workers
        begun = [subprocess.Popen(command, env=variables, cwd=folder, stderr=subprocess.DEVNULL) for command in commands]
        try:
            while not file.exists():
                time.sleep(0.1)
            from distributed import Client  # noqa: PLC0415  an extra

            with Client(scheduler_file=str(file), set_as_default=False) as client:
                client.wait_for_workers(workers)
            yield str(file), tuple(process.pid for process in begun)
        finally:
            for process in begun[::-1]:
                process.terminate()
                process.wait()


def spent_by(process: int) -> float:
    """[s] of the processor that a process has taken."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def tasks() -> str:
    """Pieces of no work."""
    from cluster_scaling import nothing  # noqa: PLC0415  as a function of a module, which workers find

    rows = []
    for workers in (1, 2):
        with cluster(workers) as (address, processes), opened(address) as engine:
            for count, size in ((200, PAYLOAD), (1000, 100), (1000, PAYLOAD), (300, 260_000)):
                before = [spent_by(pid) for pid in processes]
                begun, own = time.perf_counter(), time.process_time()
                found = sum(1 for _ in engine.spread(nothing, [bytes(size)] * count))
                assert found == count
                wall, client = time.perf_counter() - begun, time.process_time() - own
                scheduler, *others = (1e3 * (spent_by(pid) - then) / count for pid, then in zip(processes, before, strict=True))
                if count != 200:  # the first ones warm up
                    figures = (f"{scheduler:.2f}", f"{1e3 * client / count:.2f}", f"{sum(others):.2f}")
                    rows.append((str(workers), f"{size:,}", f"{count / wall:.0f}", *figures))
    return table(("workers", "bytes a piece", "pieces/s", "ms scheduler", "ms client", "ms workers"), rows)


def runs() -> str:
    """A comparison that is flown anew by each engine."""
    settings = TuningSettings(budget=400, confirm=4, validation=50, reliability=0.0)
    pieces = [(Cell(load_race("final-22"), "metropolis_hastings", settings, (seed,)),) for seed in range(16)]
    rows, answers = [], []
    for name, workers in (("processes", 1), ("processes", 2), ("cluster", 1), ("cluster", 2)):
        with cluster(workers) as (address, processes), opened(address if name == "cluster" else None, workers) as engine:
            warm = list(engine.spread(fly_cells, pieces[:workers])) if name == "cluster" else []
            begun, before, own = time.perf_counter(), [spent_by(pid) for pid in processes], os.times()
            found = list(engine.spread(fly_cells, pieces))
            wall, now = time.perf_counter() - begun, os.times()
            scheduler, *others = (spent_by(pid) - then for pid, then in zip(processes, before, strict=True))
            here = now.user + now.system - own.user - own.system
            children = now.children_user + now.children_system - own.children_user - own.children_system
            work, beside = (sum(others), scheduler + here) if name == "cluster" else (children, here)
            work, beside = (work, beside) if children or name == "cluster" else (here, 0.0)
            answers.append(sorted((run.seed, run.flights, run.cost) for _, (_, run) in found))
            del warm
        flown = sum(run.flights for _, (_, run) in found)
        rows.append((name, str(workers), f"{wall:.1f}", f"{flown / wall:.0f}", f"{work:.1f}", f"{beside:.2f}"))
    assert all(one == answers[0] for one in answers)
    return table(("engine", "workers", "s", "search flights/s", "processor s of workers", "of client and scheduler"), rows)


def simulated(workers: int, seconds: float, scheduler: float, client: float, rng: np.random.Generator) -> float:
    """Share of the workers' time that is work, in a sweep over so many workers.

    A scheduler that does one thing at a time: takes in a piece, and takes note that one is done, half of `scheduler` each. A client that
    packs or unpacks one piece at a time. A worker holds two pieces, so that it does not wait for the scheduler while it has another.

    Args:
        workers: how many.
        seconds: [s] median duration of a piece; the longest are begun first.
        scheduler: [s] that a piece takes of the scheduler.
        client: [s] that a piece takes of the client, with the time that its bytes take on the network.
        rng: draws durations.
    """
    durations = np.sort(seconds * np.exp(SPREAD * rng.standard_normal(PER_WORKER * workers)))[::-1].tolist()
    room, sent, arrived = max(AHEAD * workers, FEWEST_AHEAD), 0, deque[float]()
    free_scheduler = free_client = 0.0
    held = [deque[float]() for _ in range(workers)]
    seats = deque(list(range(workers)) * HELD)
    events: list[tuple[float, int, str, int]] = []  # when, order, what, whose
    order = 0

    def later(when: float, what: str, whose: int) -> None:
        nonlocal order
        order += 1
        heappush(events, (when, order, what, whose))

    def send(now: float) -> None:
        nonlocal free_client, sent
        free_client = max(now, free_client) + client / 2
        later(free_client, "submitted", sent)
        sent += 1

    def assign(now: float) -> None:
        while arrived and seats:
            worker = seats.popleft()
            held[worker].append(arrived.popleft())
            if len(held[worker]) == 1:
                later(now + held[worker][0], "done", worker)

    for _ in range(min(room, len(durations))):
        send(0.0)
    ended, now = 0, 0.0
    while ended < len(durations):
        now, _, what, whose = heappop(events)
        if what == "submitted":
            free_scheduler = max(now, free_scheduler) + scheduler / 2
            later(free_scheduler, "known", whose)
        elif what == "known":
            arrived.append(durations[whose])
            assign(now)
        elif what == "done":
            held[whose].popleft()
            if held[whose]:
                later(now + held[whose][0], "done", whose)
            free_scheduler = max(now, free_scheduler) + scheduler / 2
            later(free_scheduler, "noted", whose)
        elif what == "noted":
            seats.append(whose)
            assign(now)
            free_client = max(now, free_client) + client / 2
            later(free_client, "received", whose)
        else:
            ended += 1
            if sent < len(durations):
                send(now)
    return sum(durations) / (workers * now)


def simulate(scheduler: float, client: float, size: float) -> str:
    """Share of the workers' time that is work, for each number of workers and duration of a piece; mean of three sweeps."""
    rows = []
    for workers in WORKERS:
        shares = []
        for seconds in PIECES:
            found = [simulated(workers, seconds, scheduler, client + size / NETWORK, np.random.default_rng(seed)) for seed in range(3)]
            shares.append(f"{100 * float(np.mean(found)):.0f} %")
        rows.append((str(workers), *shares))
    return table(("workers (simulated)", *(f"pieces of {seconds:g} s" for seconds in PIECES)), rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=("flights", "bytes", "tasks", "runs", "simulate"))
    parser.add_argument("--out", type=Path)
    parser.add_argument("--scheduler", type=float, default=1.0, help="ms that a piece takes of the scheduler")
    parser.add_argument("--client", type=float, default=1.0, help="ms that a piece takes of the client")
    parser.add_argument("--bytes", type=float, default=10_000, help="sent and received for a piece")
    asked = parser.parse_args()
    parts = {"flights": flights, "bytes": sizes, "tasks": tasks, "runs": runs}
    found = parts[asked.part]() if asked.part in parts else simulate(1e-3 * asked.scheduler, 1e-3 * asked.client, asked.bytes)
    if asked.out is not None:
        asked.out.write_text(found, encoding="utf-8")
    sys.stdout.write(found)


if __name__ == "__main__":
    main()
