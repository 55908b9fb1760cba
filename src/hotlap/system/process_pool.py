"""Process pool: independent pieces of work over processes, whose results come back as soon as each is there.

The workers of `concurrent.futures` give one result a piece, and outlive a parent that was killed; these give many, and go with it.
"""

from __future__ import annotations

import multiprocessing
import pickle
import signal
import warnings
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, TypeVar

from hotlap.core.errors import HotlapError
from hotlap.system.blas_threads import one_thread_each
from hotlap.system.environment import variables
from hotlap.system.processors import available

Piece = TypeVar("Piece")
Item = TypeVar("Item")

DIED = "a worker process has died, perhaps for want of memory"
MOST_LOSSES = 3  # of workers that one piece may cost
NOTHING_OF_THE_FOLDER = {"PYTHONSAFEPATH": "1"}  # a worker begins with Python's own path, and then has that of its parent
_ITEM, _END, _ERROR = range(3)


def spread(work: Callable[[Piece], Iterable[Item]], pieces: Sequence[Piece], processes: int = 0) -> Iterator[tuple[Piece, Item]]:
    """Do all pieces of work in processes of this machine; see `Processes`."""
    yield from Processes(processes).spread(work, pieces)


class Processes:
    """An engine whose workers are processes of this machine.

    Args:
        count: how many; 0 for one a processor, 1 for none beside this one.
        note: called with a line where a worker was lost.
    """

    def __init__(self, count: int = 0, note: Callable[[str], None] = lambda _line: None) -> None:
        self._count, self._note = count, note

    @property
    def workers(self) -> int:
        """How many pieces are done at a time."""
        return self._count or available()

    def require(self, *files_or_modules: str | Path) -> None:
        """Nothing: processes of this machine find what is here."""

    def spread(self, work: Callable[[Piece], Iterable[Item]], pieces: Sequence[Piece]) -> Iterator[tuple[Piece, Item]]:
        """Do all pieces of work; see `engine.Engine.spread`.

        Raises:
            HotlapError: a piece has cost too many workers.
            Exception: what a piece of work raised.
        """
        crew = min(self.workers, len(pieces))
        if crew > 1:
            yield from _Crew(work, pieces, self._note).serve(crew)
            return
        for piece in pieces:
            for item in work(piece):
                yield piece, item


class _Worker:
    """A process that waits for pieces.

    Attributes:
        pipe: our end of its connection.
        index: of the piece that it does; None where it waits.
        seen: results of that piece so far.
    """

    def __init__(self, work: Callable[[Any], Iterable[Any]]) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=_serve_pipe, args=(work, theirs), daemon=True)
        self.index: int | None = None
        self.seen = 0
        with one_thread_each(), variables(NOTHING_OF_THE_FOLDER):
            self.process.start()
        theirs.close()

    def close(self) -> None:
        """Tell it to end, whatever it does."""
        self.pipe.close()
        self.process.terminate()


class _Crew:
    """Workers over the pieces of one call."""

    def __init__(self, work: Callable[[Any], Iterable[Any]], pieces: Sequence[Any], note: Callable[[str], None]) -> None:
        self._work, self._pieces, self._note = work, pieces, note
        self._waiting = deque(range(len(pieces)))
        self._given, self._losses = Counter[int](), Counter[int]()
        self._workers: list[_Worker] = []

    def serve(self, crew: int) -> Iterator[tuple[Any, Any]]:
        """Hand out pieces, collect results; the workers are stopped in whatever way it ends."""
        try:
            for _ in range(crew):
                self._begin()
            while busy := {worker.pipe: worker for worker in self._workers if worker.index is not None}:
                for pipe in wait(list(busy)):
                    worker = busy[pipe]  # pyright: ignore[reportArgumentType]  one of those it was given
                    yield from self._receive(worker)
        finally:
            for worker in self._workers:
                worker.close()
            for worker in self._workers:
                worker.process.join()

    def _begin(self) -> None:
        """One more worker, with its first piece."""
        worker = _Worker(self._work)
        self._workers.append(worker)
        self._hand_out(worker)

    def _hand_out(self, worker: _Worker) -> None:
        """Give a worker the next piece, if there is any."""
        worker.index, worker.seen = (self._waiting.popleft() if self._waiting else None), 0
        if worker.index is None:
            return
        try:
            worker.pipe.send((worker.index, self._pieces[worker.index]))
        except OSError:
            self._lose(worker)

    def _receive(self, worker: _Worker) -> Iterator[tuple[Any, Any]]:
        """What a worker says: a result, that a piece is done, or what went wrong."""
        try:
            kind, index, content = worker.pipe.recv()
        except (EOFError, OSError):
            self._lose(worker)
            return
        if kind == _ERROR:
            raise content
        if kind == _END:
            self._hand_out(worker)
            return
        worker.seen += 1
        if worker.seen > self._given[index]:  # what a lost worker gave before is not given twice
            self._given[index] += 1
            yield self._pieces[index], content

    def _lose(self, worker: _Worker) -> None:
        """Let another worker begin the piece of one that has died."""
        index = worker.index
        assert index is not None, "it was given one"  # noqa: S101  our own mistake
        worker.index = None
        worker.close()
        self._losses[index] += 1
        if self._losses[index] >= MOST_LOSSES:
            raise HotlapError(DIED)
        self._note(f"note: {DIED}; another one does its work again")
        self._waiting.appendleft(index)
        self._begin()


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
                pipe.send((_ERROR, index, portable(error)))
            pipe.send((_END, index, None))


def _in_one_line(message: Warning | str, *_: object, **__: object) -> str:
    """A warning as the command line shows it, without the place in the code that it came from."""
    return f"hotlap: warning: {message}\n"


def portable(error: Exception) -> Exception:
    """An error that can be sent between processes: itself, or another one with its message."""
    try:
        pickle.loads(pickle.dumps(error))  # noqa: S301  it is our own
    except Exception:  # noqa: BLE001  a foreign error's constructor may take anything
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
