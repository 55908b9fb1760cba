"""Process: the bridge to cflib as it runs beside hotlap, and the lines to and from it."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from hotlap.core.errors import InputError

PACKAGE = "cflib"
PROGRAM = Path(__file__).with_name("bridge.py")
CHUNK = 1 << 16  # bytes read at once
ENDING, LANDING = 2.0, 25.0  # s to end by itself, and to land before


def check_package() -> None:
    """See that cflib is there, without loading it.

    Raises:
        InputError: it is not.
    """
    if find_spec(PACKAGE) is None:
        raise InputError("", "on", f"crazyflie needs the package {PACKAGE}: pip install 'hotlap[crazyflie]'")


class Process:
    """The bridge.

    Args:
        uri: of the Crazyflie, as cflib writes it.

    Attributes:
        ended: whether it says nothing any more.
    """

    def __init__(self, uri: str) -> None:
        command = [sys.executable, "-P", str(PROGRAM), uri]
        pipe, devnull = subprocess.PIPE, subprocess.DEVNULL
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=devnull, start_new_session=True)
        self._ends = tuple(end for end in (self._process.stdin, self._process.stdout) if end is not None)
        self._input, self._output = (end.fileno() for end in self._ends)
        for end in (self._input, self._output):
            os.set_blocking(end, False)
        self._rest, self.ended = b"", False

    def tell(self, word: str, *values: Any) -> None:
        """Write a line; one that it does not take at once is lost, as on the air."""
        with suppress(OSError):
            os.write(self._input, json.dumps([word, *values]).encode() + b"\n")  # shorter than a pipe takes whole

    def hear(self, wait: float) -> list[list[Any]]:
        """Lines that have come, within so many seconds [s]."""
        if self.ended or not select.select([self._output], [], [], max(wait, 0.0))[0]:
            return []
        read = os.read(self._output, CHUNK)
        self.ended = not read
        *lines, self._rest = (self._rest + read).split(b"\n")
        return [json.loads(line) for line in lines]

    def close(self) -> None:
        """Let it end, without a word to the Crazyflie; may be called twice."""
        if self._process.returncode is None:
            self.tell("close")
        self._end(ENDING)

    def leave(self) -> None:
        """Let it end when the Crazyflie has landed."""
        self._ends[0].close()
        self._end(LANDING)

    def _end(self, wait: float) -> None:
        try:
            self._process.wait(wait)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for end in self._ends:
            with suppress(OSError):
                end.close()
