"""A dask cluster of its own for tests: scheduler and workers in processes, on this machine alone."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Self

import pytest

from hotlap.system.blas_threads import VARIABLES

TESTS = Path(__file__).parents[1]
QUIET = {"DASK_LOGGING__DISTRIBUTED": "critical", "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "3"}
LOOPBACK = ("--host", "127.0.0.1", "--no-dashboard")


class DaskCluster:
    """Scheduler and workers; a context that ends them all.

    Args:
        folder: of the scheduler's file and of the workers' own files.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.file = folder, folder / "scheduler.json"
        self.workers: list[subprocess.Popen[bytes]] = []
        self._scheduler = self._start("scheduler", *LOOPBACK, "--port", "0", "--scheduler-file", str(self.file))
        wait_until(self.file.exists)
        wait_until(lambda: self.address)

    @property
    def address(self) -> str:
        """Of the scheduler; "" while its file is being written."""
        try:
            return json.loads(self.file.read_text(encoding="utf-8"))["address"]
        except ValueError:
            return ""

    def add_worker(self, *, threads: int = 1, nanny: bool = False, environment: Mapping[str, str] | None = None) -> None:
        """One more worker; without a nanny one that is killed stays dead, with one another takes its place."""
        told = ("--nanny" if nanny else "--no-nanny", "--nthreads", str(threads), "--local-directory", str(self.folder), *LOOPBACK)
        self.workers.append(self._start("worker", self.address, *told, environment=environment))

    def wait_for(self, workers: int) -> None:
        """Wait until so many have come."""
        with pytest.importorskip("distributed").Client(self.address, set_as_default=False) as client:
            client.wait_for_workers(workers, timeout=60)

    @contextmanager
    def losing_a_worker(self) -> Iterator[None]:
        """Kill a worker while it does a piece of work that is asked for within; that it happened is asserted."""
        with pytest.importorskip("distributed").Client(self.address, set_as_default=False) as client:
            processes, killed, over = client.run(os.getpid), [], threading.Event()

            def kill() -> None:
                """As soon as one is busy, a moment later."""
                while not killed and not over.is_set():
                    busy = [worker for worker, tasks in client.processing().items() if tasks]
                    if busy:
                        time.sleep(0.1)
                        os.kill(processes[busy[0]], signal.SIGKILL)
                        killed.append(busy[0])

            thread = threading.Thread(target=kill)
            thread.start()
            try:
                yield
            finally:
                over.set()
                thread.join()
            assert killed

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for process in self.workers:
            process.terminate()  # a nanny ends its worker, too
        for process in (*self.workers, self._scheduler):
            with suppress(subprocess.TimeoutExpired):
                process.wait(10 if process in self.workers else 0)
            process.kill()
            process.wait()

    def _start(self, *words: str, environment: Mapping[str, str] | None = None) -> subprocess.Popen[bytes]:
        path = os.pathsep.join([str(TESTS), *filter(None, [os.environ.get("PYTHONPATH", "")])])
        variables = {**os.environ, **QUIET, **dict.fromkeys(VARIABLES, "1"), "PYTHONPATH": path, **(environment or {})}
        command = [sys.executable, "-m", "dask", *words]
        return subprocess.Popen(command, cwd=self.folder, env=variables, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def wait_until(true, seconds: float = 60.0) -> None:
    """Wait until something is true."""
    until = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < until, "waited in vain"
        time.sleep(0.05)


@contextmanager
def running(folder: Path, workers: int, **settings: Any) -> Iterator[DaskCluster]:
    """A cluster whose workers have joined.

    Args:
        folder: of its files.
        workers: how many.
        settings: of each, as of `add_worker`.
    """
    with DaskCluster(folder) as started:
        for _ in range(workers):
            started.add_worker(**settings)
        started.wait_for(workers)
        yield started
