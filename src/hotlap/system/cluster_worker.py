"""Cluster worker: what runs on the workers of a cluster: says what is installed there, and does pieces of work."""

from __future__ import annotations

import hashlib
import pickle
import platform
import sys
from collections.abc import Callable, Iterable
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from threadpoolctl import threadpool_limits

from hotlap.core.errors import HotlapError, InputError
from hotlap.core.version import __version__
from hotlap.system.disk_cache import digest_sources
from hotlap.system.engine import WORKING
from hotlap.system.needed import Needed, check_needed
from hotlap.system.package_data import digest_data
from hotlap.system.process_pool import portable

LIBRARIES = ("numpy", "scipy", "numba", "llvmlite", "casadi", "scikit-learn", "cmaes", "pydantic")
"""Packages whose version may decide about a digit of a result, or about what can be sent."""
WITH_DATA = ("data", "worlds")
"""Folders of hotlap with files besides Python that decide about a result; those of `report` draw pages, on the machine that asks."""
PROCESSOR = "processor"


@cache
def installation() -> dict[str, str]:
    """What is installed here, by what it is called in messages; the `PROCESSOR` may differ between workers, nothing else.

    Needs no package that hotlap does not.
    """
    return {
        "Python": f"{platform.python_implementation()} {sys.version_info.major}.{sys.version_info.minor}",
        "hotlap": __version__,
        **{name: _version(name) for name in LIBRARIES},
        "hotlap's code": digest_sources("hotlap"),
        "hotlap's data": digest_data(*WITH_DATA),
        PROCESSOR: _processor(),
    }


def fingerprint() -> str:
    """Sixteen hexadecimal digits of all that must be the same on every worker."""
    same = {name: value for name, value in installation().items() if name != PROCESSOR}
    return hashlib.sha256(repr(sorted(same.items())).encode()).hexdigest()[:16]


def _version(package: str) -> str:
    """The version of a package; "-" where it is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "-"


def _processor() -> str:
    """Kind of processor and of C library: what compiled code and elementary functions depend on."""
    from llvmlite import binding  # noqa: PLC0415  it loads LLVM

    features = ",".join(sorted(name for name, has in binding.get_host_cpu_features().items() if has))
    digest = hashlib.sha256(features.encode()).hexdigest()[:6]
    return f"{platform.system()} {platform.machine()}, {binding.get_host_cpu_name()} ({digest}), {' '.join(platform.libc_ver())}".rstrip(
        ", "
    )


def do(task: bytes, expected: str) -> bytes:
    """Do a piece of work on a worker, which may have joined after all others were looked at.

    Args:
        task: what `pack` gives.
        expected: the fingerprint of whoever asks.

    Returns:
        Pickled (results, None), or with the error that came after them.
    """
    if fingerprint() != expected:
        reason = f"worker on {platform.node()} has another installation of hotlap, Python or a library than this one"
        return pickle.dumps(([], InputError("", "cluster", reason)))
    if (threads := _threads()) != 1:
        return pickle.dumps(([], InputError("", "cluster", told_of_threads(f"on {platform.node()}", threads))))
    results: list[Any] = []
    token = WORKING.set(True)
    try:
        work, piece, needed = pickle.loads(task)  # noqa: S301  from the user's own program, over the user's own cluster
        check_needed(needed)
        with threadpool_limits(limits=1):
            results.extend(work(piece))
        return pickle.dumps((results, None))
    except Exception as error:  # noqa: BLE001  whatever it was, whoever asked raises it
        return pickle.dumps((results, portable(error)))
    finally:
        WORKING.reset(token)


def told_of_threads(worker: str, threads: int) -> str:
    """Why a worker is refused that does several pieces of work at a time."""
    return f"worker {worker} has {threads} threads, and should have one: --nworkers N --nthreads 1"


def _threads() -> int:
    """How many pieces of work the worker that this is done on does at a time; 1 where it is done on none."""
    try:
        from distributed import get_worker  # noqa: PLC0415  an extra

        return get_worker().state.nthreads
    except (ImportError, ValueError):
        return 1


def unpack(answer: bytes) -> tuple[list[Any], Exception | None]:
    """What `do` gives: the results of a piece, and the error that came after them."""
    return pickle.loads(answer)  # noqa: S301  from the user's own workers


def pack(work: Callable[[Any], Iterable[Any]], piece: Any, needed: Needed) -> bytes:
    """A piece of work as bytes, which only the worker reads again.

    Raises:
        HotlapError: it cannot be sent.
    """
    if work.__module__ == "__main__":
        raise HotlapError(f"cannot be sent to a worker: {work.__name__} must be a function of a module")
    try:
        return pickle.dumps((work, piece, needed))
    except (pickle.PicklingError, TypeError, AttributeError) as error:
        raise HotlapError(f"cannot be sent to a worker: {error}") from error
