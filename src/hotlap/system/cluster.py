"""Cluster: an engine whose workers are those of a dask scheduler, on any number of machines.

Before any work is sent every worker is asked what is installed there. What a lost worker had begun dask lets others do again. Messages are
pickled, as all of dask's are: the scheduler and its workers belong to the user, on a network of the user's own.
"""

from __future__ import annotations

import json
import logging
import warnings
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any, TypeVar

from hotlap.core.counts import count
from hotlap.core.errors import HotlapError, InputError
from hotlap.system import cluster_worker
from hotlap.system.cluster_worker import PROCESSOR, installation, told_of_threads
from hotlap.system.needed import Needed, digest_needed

if TYPE_CHECKING:
    from distributed import Client, Future, as_completed

Piece = TypeVar("Piece")
Item = TypeVar("Item")

TIMEOUT = 5.0  # s to connect
PAUSE = 0.02  # s between looks for results
LOOK = 2.0  # s between looks at the workers
PATIENCE = 600.0  # s that work waits for a worker where all have gone
AHEAD = 4  # pieces on the cluster for each worker, so that none waits for us
FEWEST_AHEAD = 64


def connect(address: str, note: Callable[[str], None] = lambda _line: None) -> Cluster:
    """A cluster whose workers compute what this machine would.

    Args:
        address: `tcp://host:8786`, `tls://...`, or the file that a scheduler writes for `--scheduler-file`.
        note: called with a line that a person should know of.

    Raises:
        InputError: dask.distributed is not installed, the scheduler is not there, has no workers, or ones that are not installed as we are.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            from distributed import Client  # noqa: PLC0415  an extra, and slow to load
    except ImportError:
        raise InputError("", "cluster", "needs dask.distributed: pip install 'hotlap[cluster]'") from None
    for name in ("distributed", "distributed.client", "distributed.core", "distributed.comm"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what goes wrong is told by us, in one line
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of versions that differ; we look ourselves
            client = Client(_address(address), timeout=TIMEOUT, set_as_default=False)
    except (OSError, ValueError, TypeError, ImportError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError("", "cluster", f"there is no scheduler at {address}: {reason}") from None
    try:
        _check_workers(client, address, note)
    except BaseException:
        client.close()
        raise
    return Cluster(client, address, note)


class Cluster:
    """An engine over a connected client; see `connect`.

    Attributes:
        sent, received: bytes of pieces of work and of their results so far.
        patience: [s] that work waits for a worker where all have gone.
    """

    def __init__(self, client: Client, address: str, note: Callable[[str], None]) -> None:
        self._client, self._address, self._note = client, address, note
        self._known = set(_threads(client))
        self._needed: Needed = ()
        self._out: set[Future] = set()
        self.sent = self.received = 0
        self.patience = PATIENCE
        self._looked = monotonic()

    @property
    def workers(self) -> int:
        """How many pieces are done at a time; those that join later do their share, too."""
        return max(1, len(self._known))

    def require(self, *files_or_modules: str | Path) -> None:
        """Let work be refused by a worker where these are not what they are here; what is no file and no module counts for nothing."""
        known = ((str(what), digest_needed(str(what))) for what in files_or_modules)
        self._needed = tuple(dict.fromkeys((*self._needed, *(pair for pair in known if pair[1]))))

    def spread(self, work: Callable[[Piece], Iterable[Item]], pieces: Sequence[Piece]) -> Iterator[tuple[Piece, Item]]:
        """Do all pieces of work; see `engine.Engine.spread`. The results of a piece arrive together.

        Raises:
            HotlapError: the scheduler has gone, all workers have, or one piece has cost too many of them.
            Exception: what a piece of work raised.
        """
        from distributed import as_completed  # noqa: PLC0415  an extra

        ended = as_completed(loop=self._client.loop, with_results=True, raise_errors=False)
        waiting, mine = deque(range(len(pieces))), dict[Any, int]()
        try:
            while waiting or mine:
                room = max(AHEAD * self.workers, FEWEST_AHEAD) - len(mine)
                indices = [waiting.popleft() for _ in range(min(room, len(waiting)))]
                fresh = self._send([cluster_worker.pack(work, pieces[index], self._needed) for index in indices])
                mine.update(zip(fresh, indices, strict=True))
                ended.update(fresh)
                for future, answer in self._next(ended):
                    index = mine.pop(future)
                    results, error = self._read(future, answer)
                    for item in results:
                        yield pieces[index], item
                    if error is not None:
                        raise error
        finally:
            self._cancel(list(mine))

    def close(self) -> None:
        """Cancel what waits, and leave the cluster."""
        self._cancel(list(self._out))
        with suppress(Exception):
            self._client.close()

    def _send(self, tasks: Sequence[bytes]) -> list[Future]:
        """Hand pieces of work to the scheduler."""
        if not tasks:
            return []
        self.sent += sum(map(len, tasks))
        expected = cluster_worker.fingerprint()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of many bytes at once
            fresh = self._client.map(cluster_worker.do, tasks, expected=expected, pure=False, batch_size=len(tasks))
        self._out.update(fresh)
        return fresh

    def _next(self, ended: as_completed) -> list[tuple[Future, Any]]:
        """Those that have ended since, at least one; looks at the workers meanwhile.

        Raises:
            HotlapError: nobody is there any more to end one.
        """
        waited = monotonic()
        while True:
            if monotonic() - self._looked >= LOOK:
                waited = monotonic() if self._look() else waited
                self._looked = monotonic()
            found = ended.next_batch(block=False)
            if found:
                return found  # pyright: ignore[reportReturnType]  pairs, as results are asked for
            if monotonic() - waited > self.patience:
                raise HotlapError(f"the scheduler at {self._address} has had no worker for {self.patience:.0f} s; what has ended is kept")
            sleep(PAUSE)

    def _look(self) -> bool:
        """Whether there is a worker; says which have gone.

        Raises:
            HotlapError: the scheduler has gone.
        """
        try:
            here = set(_threads(self._client)) if self._client.status == "running" else None
        except Exception:  # noqa: BLE001  dask raises errors of many kinds
            here = None
        if here is None:
            raise HotlapError(f"the scheduler at {self._address} has gone; what has ended is kept")
        gone, before, self._known = self._known - here, self._known, here
        if gone:
            rest = f"{count(len(here), 'worker')} left" if here else "none is left, so it waits for others"
            self._note(f"note: {count(len(gone), 'worker')} of the cluster lost, what they had begun is done again; {rest}")
        elif here and not before:
            self._note(f"note: {count(len(here), 'worker')} joined the cluster")
        return bool(here)

    def _read(self, future: Future, answer: Any) -> tuple[list[Any], Exception | None]:
        """Results of a piece, and the error that came after them.

        Raises:
            HotlapError: it has cost too many workers, or was cancelled.
        """
        from distributed import KilledWorker  # noqa: PLC0415  an extra

        self._out.discard(future)
        future.release()
        if isinstance(answer, bytes):
            self.received += len(answer)
            return cluster_worker.unpack(answer)
        error = answer[1] if isinstance(answer, tuple) else answer  # dask's own; ours arrive as results
        if isinstance(error, KilledWorker):
            raise HotlapError("a piece of work has ended every worker that began it, perhaps for want of memory")
        reason = " ".join(str(error).split()) or type(error).__name__
        raise HotlapError(f"the cluster at {self._address} has failed: {reason}")

    def _cancel(self, futures: Sequence[Future]) -> None:
        """Take pieces back from the cluster."""
        for future in futures:
            self._out.discard(future)
        if futures:
            with suppress(Exception):
                self._client.cancel(futures, force=True, reason="the program that asked for it was stopped")


def _address(given: str) -> str:
    """The address that was given, or that a scheduler wrote into the file that was given.

    Raises:
        InputError: the file is not there, or none of a scheduler.
    """
    if "://" in given or not (given.endswith(".json") or Path(given).is_file()):
        return given
    try:
        return str(json.loads(Path(given).read_text(encoding="utf-8"))["address"])
    except OSError as error:
        raise InputError("", "cluster", f"{given}: {error.strerror or error}") from None
    except (ValueError, KeyError, TypeError):
        raise InputError("", "cluster", f"{given} is not the file of a scheduler, as dask scheduler --scheduler-file writes it") from None


def _check_workers(client: Client, address: str, note: Callable[[str], None]) -> None:
    """Refuse workers that could compute something else than we would.

    Raises:
        InputError: with the first worker, and what is different there.
    """
    threads = _threads(client)
    if not threads:
        start = f"dask worker {address} --nworkers -1 --nthreads 1"
        raise InputError("", "cluster", f"the scheduler at {address} has no workers; start some: {start}")
    for worker, number in sorted(threads.items()):
        if number != 1:
            raise InputError("", "cluster", told_of_threads(worker, number))
    versions: Any = client.get_versions()
    ours = _python(versions["client"])
    for where, theirs in (("the scheduler", versions["scheduler"]), *((f"worker {one}", had) for one, had in versions["workers"].items())):
        if _python(theirs) != ours:
            raise InputError("", "cluster", f"{where} runs Python {_python(theirs)}, not {ours} as here")
    found = _installations(client)
    mine = installation()
    for worker, theirs in sorted(found.items()):
        for what, here in mine.items():
            if what != PROCESSOR and theirs.get(what) != here:
                raise InputError("", "cluster", f"worker {worker} has {_told(what, theirs.get(what))}, not {here} as here")
    _say_who(found, mine, address, note)


def _threads(client: Client) -> dict[str, int]:
    """Number of threads of each worker, by its address."""
    found: Any = client.nthreads()
    return dict(found)


def _python(versions: Mapping[str, Any]) -> str:
    """As in 3.12."""
    return ".".join(str(versions["host"]["python"]).split(".")[:2])


def _told(what: str, value: str | None) -> str:
    """What a worker has, in words."""
    return f"no {what}" if value in {None, "-"} else f"{what} {value}"


def _installations(client: Client) -> dict[str, dict[str, str]]:
    """What is installed on each worker; nothing where it cannot say."""
    answers: Any = client.run(cluster_worker.installation, on_error="return")
    return {worker: answer if isinstance(answer, dict) else {"hotlap": "-"} for worker, answer in answers.items()}


def _say_who(found: Mapping[str, Mapping[str, str]], mine: Mapping[str, str], address: str, note: Callable[[str], None]) -> None:
    """How many workers there are, on how many machines, and whether they are of another kind than this one."""
    machines = {worker.rpartition(":")[0] for worker in found}
    note(f"{count(len(found), 'worker')} on {count(len(machines), 'machine')} at {address}")
    others = Counter(theirs[PROCESSOR] for theirs in found.values() if theirs[PROCESSOR] != mine[PROCESSOR])
    if others:
        kinds = "; ".join(f"{count(number, 'worker')}: {kind}" for kind, number in others.most_common())
        note(f"note: results may differ in the last digit from those of this machine ({mine[PROCESSOR]}): {kinds}")
