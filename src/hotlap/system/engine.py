"""Engine: where independent pieces of work are done: processes of this machine, or workers of a cluster.

Whatever the engine, no result depends on which worker did a piece, in which order, or how often: a piece whose worker was lost is done
again by another, and of what it gave before nothing is given twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from multiprocessing import parent_process
from pathlib import Path
from typing import Protocol, TypeVar

from hotlap.core.errors import InputError
from hotlap.system.process_pool import Processes

Piece = TypeVar("Piece")
Item = TypeVar("Item")

WORKING: ContextVar[bool] = ContextVar("WORKING", default=False)
"""True while a worker of a cluster does a piece of work."""


class Engine(Protocol):
    """Where pieces of work are done, several at a time.

    Attributes:
        workers: how many are done at a time.
    """

    @property
    def workers(self) -> int:
        """How many pieces are done at a time."""
        ...

    def require(self, *files_or_modules: str | Path) -> None:
        """Let work be refused by a worker where one of these is not what it is here: a file, or a module by its dotted name."""
        ...

    def spread(self, work: Callable[[Piece], Iterable[Item]], pieces: Sequence[Piece]) -> Iterator[tuple[Piece, Item]]:
        """Do all pieces of work; what is begun or waits when the iterator is closed is given up.

        Args:
            work: gives the results of a piece, one after the other, the same each time; a function of a module, which workers find.
            pieces: in the order in which they are begun.

        Yields:
            A piece and a result of it, in the order in which they arrive; those of one piece in their own order.

        Raises:
            Exception: what a piece of work raised; the others are given up.
        """
        ...


def is_one_of_many() -> bool:
    """Whether this is a worker beside others, one for each processor, so that one thread is enough."""
    return parent_process() is not None or WORKING.get()


def check_jobs(jobs: int, cluster: str | None) -> None:
    """Refuse numbers of processes that make no sense.

    Raises:
        InputError: negative, or asked for beside a cluster, which has the workers that it has.
    """
    if jobs < 0:
        raise InputError("", "jobs", f"must not be negative, not {jobs}")
    if jobs and cluster is not None:
        raise InputError("", "jobs", "are processes of this machine; a cluster has the workers that it has")


@contextmanager
def opened(cluster: str | None, processes: int = 0, note: Callable[[str], None] = lambda _line: None) -> Iterator[Engine]:
    """The engine that was asked for; whatever still waits on a cluster is cancelled when the block ends.

    Args:
        cluster: address or scheduler file of a dask scheduler; None: processes of this machine.
        processes: how many there; 0 for one a processor.
        note: called with a line that a person should know of.

    Raises:
        InputError: the cluster is not there, has no workers, or another installation than ours.
    """
    if cluster is None:
        yield Processes(processes, note)
        return
    from hotlap.system.cluster import connect  # noqa: PLC0415  only where there is a cluster

    engine = connect(cluster, note)
    try:
        yield engine
    finally:
        engine.close()
