"""Process pool: independent pieces of work over processes, whose results come back as soon as each is there.

The workers of `concurrent.futures` give one result a piece, and outlive a parent that was killed; these give many, and go with it.
"""

from __future__ import annotations

import multiprocessing
import pickle
import signal
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, TypeVar

from hotlap.core.errors import HotlapError
from hotlap.system.blas_threads import one_thread_each
from hotlap.system.environment import variables
from hotlap.system.processors import available

Piece = TypeVar("Piece")
Item = TypeVar("Item")

DIED = "a worker process has died, perhaps for want of memory"
NOTHING_OF_THE_FOLDER = {"PYTHONSAFEPATH": "1"}  # a worker begins with Python's own path, and then has that of its parent

_ITEM, _END, _ERROR = range(3)


def spread(work: Callable[[Piece], Iterable[Item]], pieces: Sequence[Piece], processes: int = 0) -> Iterator[tuple[Piece, Item]]:
    """Do all pieces of work, several at a time.

    Args:
        work: gives the results of a piece, one after the other; a function of a module, so that workers can find it.
        pieces: in the order in which they are begun.
        processes: how many; 0 for one a processor, 1 for none beside this one.

    Yields:
        A piece and a result of it, in the order in which they arrive.

    Raises:
        Exception: what a piece of work raised; the others are stopped.
    """
    crew = min(processes or available(), len(pieces))
    if crew <= 1:
        for piece in pieces:
            for item in work(piece):
                yield piece, item
        return
    with _workers(work, crew) as workers:
        yield from _serve(workers, deque(enumerate(pieces)), pieces)


def _serve(workers: Sequence[Connection], waiting: deque[tuple[int, Any]], pieces: Sequence[Any]) -> Iterator[tuple[Any, Any]]:
    """Hand out pieces, collect results."""
    busy = set()
    for worker in workers:
        _hand_out(worker, waiting)
        busy.add(worker)
    while busy:
        for worker in wait(list(busy)):
            assert isinstance(worker, Connection)  # noqa: S101  what it was given
            try:
                kind, index, content = worker.recv()
            except (EOFError, OSError):
                raise HotlapError(DIED) from None
            if kind == _ERROR:
                raise content
            if kind == _ITEM:
                yield pieces[index], content
            elif waiting:
                _hand_out(worker, waiting)
            else:
                busy.discard(worker)


def _hand_out(worker: Connection, waiting: deque[tuple[int, Any]]) -> None:
    """Give a worker the next piece."""
    try:
        worker.send(waiting.popleft())
    except OSError:
        raise HotlapError(DIED) from None


@contextmanager
def _workers(work: Callable[[Any], Iterable[Any]], crew: int) -> Iterator[list[Connection]]:
    """Worker processes that wait for pieces; they are stopped when the block ends, in whatever way."""
    context = multiprocessing.get_context("spawn")
    processes: list[BaseProcess] = []
    ours: list[Connection] = []
    try:
        with one_thread_each(), variables(NOTHING_OF_THE_FOLDER):
            for _ in range(crew):
                mine, theirs = context.Pipe()
                process = context.Process(target=_serve_pipe, args=(work, theirs), daemon=True)
                process.start()
                theirs.close()
                processes.append(process)
                ours.append(mine)
        yield ours
    finally:
        for connection in ours:
            connection.close()
        for process in processes:
            process.terminate()
        for process in processes:
            process.join()


def _serve_pipe(work: Callable[[Any], Iterable[Any]], pipe: Connection) -> None:
    """The loop of a worker process: it ends when its parent closes the pipe; Ctrl-C is left to the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    warnings.formatwarning = _in_one_line
    with suppress(EOFError, BrokenPipeError, ConnectionResetError):
        while True:
            index, piece = pipe.recv()
            try:
                for item in work(piece):
                    pipe.send((_ITEM, index, item))
            except (BrokenPipeError, ConnectionResetError):
                raise
            except Exception as error:  # noqa: BLE001  whatever it was, the parent raises it
                pipe.send((_ERROR, index, _portable(error)))
            pipe.send((_END, index, None))


def _in_one_line(message: Warning | str, *_: object, **__: object) -> str:
    """A warning as the command line shows it, without the place in the code that it came from."""
    return f"hotlap: warning: {message}\n"


def _portable(error: Exception) -> Exception:
    """An error that can be sent between processes: itself, or another one with its message."""
    try:
        pickle.loads(pickle.dumps(error))  # noqa: S301  it is our own
    except Exception:  # noqa: BLE001  a foreign error's constructor may take anything
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
