"""The kernel cache: compiled flight code on disk, found by the sources it was made from.

Numba's own cache looks at the file of the compiled function alone: an edit of anything that the function calls would go unnoticed.
Here the place on disk changes with every source that takes part, and Numba adds its own version, the processor and its features.
Of several processes that want a kernel which is not there yet, one compiles it and the others wait for it.

What Numba keeps is machine code and pickle, which does whatever it says: it is read from a folder that is one's own alone
(`system/ownership.py`), from files that are as they were written (`system/sealed.py`), and compiled anew where it is not.
"""

# pyright: reportIncompatibleMethodOverride=false
# Numba's abstract methods have no return types.

from __future__ import annotations

import fcntl
import hashlib
import os
import pickle
import sys
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from time import sleep
from typing import Any

from numba.core import caching

from hotlap.system import sealed
from hotlap.system.disk_cache import digest_sources, folder
from hotlap.system.ownership import make_private

SOURCES = ("hotlap.flight", "hotlap.dynamics", "hotlap.race", "hotlap.reference.reference", "hotlap.core.records")
PAUSE, LONGEST_WAIT = 0.1, 180.0  # s between two looks for what another process compiles; s after which it is compiled here too


def place() -> Path:
    """The folder of kernels made from the present sources; need not exist yet."""
    return folder("kernels", digest_sources(*SOURCES))


class _Locator(caching._CacheLocator):  # noqa: SLF001 - Numba has no public door to its cache
    """Tells Numba where a kernel lies; kernels never get stale, since other sources have another place."""

    def __init__(self, function: Any, label: str) -> None:
        self._function, self._label = function, label

    def ensure_cache_path(self) -> None:
        make_private(place())

    def get_cache_path(self) -> str:
        return str(place())

    def get_source_stamp(self) -> tuple[str, str]:
        return version("numba"), version("llvmlite")

    def get_disambiguator(self) -> str:
        return self._label


class _Implementation(caching.CompileResultCacheImpl):
    """Numba's way to store compiled functions, in our folder."""

    def __init__(self, function: Any, label: str) -> None:
        self._locator = _Locator(function, label)
        self._lineno = function.__code__.co_firstlineno
        self._filename_base = self.get_filename_base("kernel", getattr(sys, "abiflags", ""))


class _Files(caching.IndexDataCacheFile):
    """Numba's index of compiled functions and their data, in sealed files."""

    def load(self, key: Any) -> Any:
        """The data of a key, None where there are none, or where another process is about to write them."""
        name = self._load_index().get(key)
        found = None if name is None else self._load_data(name)
        return found[1] if found is not None and found[0] == key else None

    def save(self, key: Any, data: Any) -> None:
        """Keep data with their key: an index and what it names are not written at one stroke."""
        super().save(key, (key, data))

    def _load_index(self) -> dict[Any, str]:
        """Names of data files by key; an index of another compiler counts as an empty one."""
        path = Path(self._index_path)
        content = sealed.read(path)
        if content is None:
            return {}
        try:
            made_by, rest = content.split(b"\n", 1)
            return dict(pickle.loads(rest)) if made_by == self._made_by() else {}  # noqa: S301  sealed, in a folder of one's own
        except Exception:  # noqa: BLE001  what is no index may fail in any way
            sealed.reject(path, "is damaged")
            return {}

    def _save_index(self, overloads: dict[Any, str]) -> None:
        sealed.write(Path(self._index_path), self._made_by() + b"\n" + self._dump(overloads))

    def _load_data(self, name: str) -> Any:
        content = sealed.read(Path(self._data_path(name)))
        return None if content is None else pickle.loads(content)  # noqa: S301  sealed, in a folder of one's own

    def _save_data(self, name: str, data: Any) -> None:
        sealed.write(Path(self._data_path(name)), self._dump(data))

    def _made_by(self) -> bytes:
        """The compiler, in one line."""
        return repr((self._version, self._source_stamp)).encode()


class Turn:
    """A lock for the compilation of one function: one process holds it at a time, and loses it when it ends, in whatever way.

    Args:
        path: of a lock file, which need not exist.
    """

    def __init__(self, path: Path) -> None:
        self.path, self._lock, self._waits = path, -1, 0

    def take(self) -> bool:
        """Whether this process may compile now: no other does, or has for too long, or files cannot be locked here."""
        if self._lock >= 0:
            return True
        try:
            make_private(self.path.parent)
            self._lock = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.give_back()
            self._waits += 1
            return self._waits * PAUSE >= LONGEST_WAIT
        except OSError:  # a folder that cannot be written, a file system without locks
            self.give_back()
        return True

    def give_back(self) -> None:
        """Let other processes compile."""
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1


class KernelCache(caching.FunctionCache):
    """The cache of one of Numba's dispatchers; a folder that cannot be read or written is no error, it only compiles again.

    Args:
        function: what the dispatcher compiles.
        label: its name in the cache, different from that of any other function.
    """

    def __init__(self, function: Any, label: str) -> None:
        self._name, self._py_func = label, function
        self._impl = _Implementation(function, label)
        locator, name = self._impl.locator, self._impl.filename_base
        self._cache_path = locator.get_cache_path()
        self._cache_file = _Files(self._cache_path, name, locator.get_source_stamp())
        self._turn = Turn(Path(self._cache_path) / f"{name}.lock")
        self.enable()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled function of a signature, None where it is to be compiled here: there is none, or a damaged one.

        Where another process compiles it, it is waited for.
        """
        found = self._load(sig, target_context)
        while found is None and not self._turn.take():
            sleep(PAUSE)
            found = self._load(sig, target_context)
        found = found or self._load(sig, target_context)  # it may have come between the look and the turn
        if found is not None:
            self._turn.give_back()
        return found

    def _load(self, sig: Any, target_context: Any) -> Any:
        """The compiled function of a signature, None where there is none or it is damaged."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # noqa: BLE001  a damaged file may fail in any way, and is then made anew
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled function if that can be done."""
        with suppress(OSError):
            super().save_overload(sig, data)
        self._turn.give_back()

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        """Numba's key without the code of the function: folder and label say which one it is."""
        return sig, codegen.magic_tuple()

    def is_filled(self, codegen: Any) -> bool:
        """Whether something was compiled from the present sources, for what a code generator compiles for."""
        kept = self._cache_file._load_index()  # noqa: SLF001
        return any(processor == codegen.magic_tuple() and (Path(self._cache_path) / name).exists() for (_, processor), name in kept.items())

    def check_file(self, codegen: Any) -> Path:
        """The file beside the compiled code for the result of its self-check, another one for each compiler and processor."""
        made_by = hashlib.sha256(repr((codegen.magic_tuple(), self._impl.locator.get_source_stamp())).encode()).hexdigest()
        return Path(self._cache_path) / f"{self._impl.filename_base}.{made_by[:16]}.txt"


def keep(dispatcher: Any, label: str) -> Any:
    """Let a dispatcher store what it compiles, and load it the next time; without a compiler, nothing changes.

    Args:
        dispatcher: a function that Numba compiles.
        label: its name in the cache, different from that of any other function.
    """
    if hasattr(dispatcher, "py_func"):
        dispatcher._cache = KernelCache(dispatcher.py_func, label)  # noqa: SLF001
    return dispatcher


def is_filled(dispatcher: Any) -> bool:
    """Whether a function is compiled already, here or in the cache."""
    cache = getattr(dispatcher, "_cache", None)
    return cache is None or bool(dispatcher.signatures) or cache.is_filled(dispatcher.targetctx.codegen())


def check_file_of(dispatcher: Any) -> Path | None:
    """The file for the result of a kernel's self-check, which need not exist; None where there is no compiler."""
    cache = getattr(dispatcher, "_cache", None)
    return None if cache is None else cache.check_file(dispatcher.targetctx.codegen())
