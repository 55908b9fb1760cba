"""Trials: inputs given to a reader; it may accept or refuse them with one line, and nothing else."""

from __future__ import annotations

import os
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

from hotlap.core.errors import HotlapError

MOST_SECONDS, MOST_MEGABYTES = 5.0, 500.0
PATIENCE = 60.0  # s of waiting, on a machine that does other things, too
WRITES = 0o3  # of the flags of an opening: to write, or both
PROGRAMS = ("bb2csv",)  # that a reader may run


class HangError(BaseException):
    """A reader takes longer than it may; no reader catches this."""


@dataclass
class Figures:
    """What became of the inputs of one reader.

    Attributes:
        name: of the reader.
        inputs, refused, accepted: how many.
        longest: [s] of the processor that one input took.
        memory: [MB] that the process took at most.
        faults: what should not have been, by the number of the input.
    """

    name: str
    inputs: int = 0
    refused: int = 0
    accepted: int = 0
    longest: float = 0.0
    memory: float = 0.0
    faults: list[str] = field(default_factory=list)


def attempt(name: str, give: Callable[[Random], Callable[[], Any]], inputs: int, folder: Path, first: int = 0) -> Figures:
    """Give a reader many inputs, each drawn by its number, so that one that fails can be given again.

    Args:
        name: of the reader.
        give: draws an input, prepares it, and gives what reads it.
        inputs: how many.
        folder: the only one in which files may be written.
        first: number of the first.
    """
    figures, before = Figures(name), _memory()
    former, tempfile.tempdir = tempfile.tempdir, str(folder.resolve())  # where files without a name are
    try:
        _give(figures, give, range(first, first + inputs), folder)
    finally:
        tempfile.tempdir = former
    figures.memory = _memory()
    if figures.memory - before > MOST_MEGABYTES:
        figures.faults.append(f"{name}: takes {figures.memory - before:.0f} MB")
    return figures


def _give(figures: Figures, give: Callable[[Random], Callable[[], Any]], numbers: range, folder: Path) -> None:
    """Give the inputs of some numbers."""
    name = figures.name
    for number in numbers:
        read = give(Random(f"{name} {number}"))
        begin = time.process_time()
        try:
            with _watched(folder), _in_time(), warnings.catch_warnings():
                warnings.simplefilter("error")
                read()
            figures.accepted += 1
        except HotlapError as error:
            figures.refused += 1
            if "\n" in str(error) or not str(error).isprintable():
                figures.faults.append(f"{name} {number}: not one line: {str(error)!r}")
        except (Exception, HangError):  # noqa: BLE001  all of them are what is looked for
            figures.faults.append(f"{name} {number}: {traceback.format_exc()}")
        figures.faults += [f"{name} {number}: {said}" for said in _misdeeds]
        _misdeeds.clear()
        figures.inputs += 1
        spent = time.process_time() - begin
        if spent > MOST_SECONDS:
            figures.faults.append(f"{name} {number}: takes {spent:.1f} s")
        figures.longest = max(figures.longest, spent)


def _memory() -> float:
    """[MB] that this process has taken at most."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)


@contextmanager
def _in_time() -> Iterator[None]:
    """Whatever does not end is ended."""

    def stop(*_: object) -> None:
        raise HangError(f"has not ended within {PATIENCE:g} s")

    former = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, PATIENCE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, former)


_allowed: list[str] = []
_misdeeds: list[str] = []


def _guard(event: str, arguments: tuple[Any, ...]) -> None:
    """Fails where a file outside of the allowed folder is written, or a program is run; a reader may catch that, so it is kept, too."""
    if not _allowed:
        return
    said = ""
    if event == "subprocess.Popen" and any(str(word).endswith(PROGRAMS) for word in arguments[1]):
        return
    if event in {"os.system", "subprocess.Popen", "os.exec", "os.posix_spawn", "socket.connect"}:
        said = f"runs or reaches something: {event} {arguments!r}"
    elif event == "open" and isinstance(arguments[0], str) and isinstance(arguments[2], int) and arguments[2] & WRITES:
        path = os.path.realpath(arguments[0])
        if not path.startswith(_allowed[0]) and not path.startswith("/dev/"):
            said = f"writes outside of its folder: {path}"
    if said:
        _misdeeds.append(said)
        raise AssertionError(said)


_hooked: list[bool] = []


@contextmanager
def _watched(folder: Path) -> Iterator[None]:
    if not _hooked:
        sys.addaudithook(_guard)  # stays until the process ends
        _hooked.append(True)
    _allowed.append(str(folder.resolve()))
    try:
        yield
    finally:
        _allowed.clear()
