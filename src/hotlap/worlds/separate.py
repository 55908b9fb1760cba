"""Separate: a simulator written in Python in a process of its own, so that several of them do not wait for one interpreter."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import HotlapError
from hotlap.system.blas_threads import one_thread_each
from hotlap.system.environment import variables
from hotlap.worlds.simulator import Simulator, SimulatorError, Start

Floats = NDArray[np.float64]

OPENING, TIMEOUT = 900.0, 120.0  # s that an answer may take; opening imports and compiles what it needs
PROGRAM = "import sys; from hotlap.worlds.separate import serve; serve(int(sys.argv[1]))"


class Separate:
    """A simulator in a process of its own. A user's program needs no guard for that, as with `multiprocessing`: it is not loaded there.

    Args:
        opened: makes the simulator there; a function or class of a module, so that the process can find it.
        arguments: of `opened`.
        environment: variables of its environment, beside ours.

    Attributes:
        lanes, step, scales_thrust: the simulator's.

    Raises:
        SimulatorError: it cannot be opened, or is lost later on.
    """

    def __init__(self, opened: Callable[..., Simulator], *arguments: Any, environment: Mapping[str, str] = MappingProxyType({})) -> None:
        ours, theirs = socket.socketpair()
        found = {"PYTHONPATH": os.pathsep.join(path or str(Path.cwd()) for path in sys.path), **environment}
        with theirs:
            command = [sys.executable, "-P", "-c", PROGRAM, str(theirs.fileno())]  # -P: nothing of the folder that it runs in
            with one_thread_each(), variables(found):
                self._process = subprocess.Popen(command, pass_fds=[theirs.fileno()])
        self._pipe = Connection(ours.detach())
        with suppress(OSError):  # one that has ended already says so below
            self._pipe.send((opened, arguments))
        self._seen: tuple[Floats, Floats] = (np.empty((0, 13)), np.empty((0, 4)))
        self.lanes, self.step, self.scales_thrust = self._answer(OPENING)

    def reset(self, lane: int, start: Start) -> None:
        """Place a drone."""
        self._seen = self._ask("reset", lane, start)

    def advance(self, commands: Floats, duration: float) -> None:
        """Let all lanes fly for a duration [s] under commands, shape (L, 4)."""
        self._seen = self._ask("advance", commands, duration)

    def states(self) -> Floats:
        """Where the drones are, shape (L, 13)."""
        return self._seen[0]

    def rotor_thrusts(self) -> Floats:
        """What the rotors give, shape (L, 4) [N]."""
        return self._seen[1]

    def close(self) -> None:
        """End the process."""
        self._pipe.close()
        self._process.terminate()
        self._process.wait()

    def _ask(self, *what: Any) -> Any:
        try:
            self._pipe.send(what)
        except OSError as error:
            raise SimulatorError("the simulator's process has ended") from error
        return self._answer()

    def _answer(self, timeout: float = TIMEOUT) -> Any:
        try:
            if not self._pipe.poll(timeout):
                raise SimulatorError(f"the simulator's process has not answered for {timeout:g} s")
            answer = self._pipe.recv()
        except (EOFError, OSError) as error:
            raise SimulatorError("the simulator's process has ended") from error
        if isinstance(answer, Exception):
            self.close()
            raise answer
        return answer


def serve(descriptor: int) -> None:
    """Do what is asked over a socket until its other end is closed; Ctrl-C is left to the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    pipe = Connection(descriptor)
    with suppress(EOFError, OSError):
        try:
            opened, arguments = pipe.recv()
            simulator = opened(*arguments)
            pipe.send((simulator.lanes, simulator.step, simulator.scales_thrust))
            while True:
                method, *told = pipe.recv()
                getattr(simulator, method)(*told)
                pipe.send((simulator.states(), simulator.rotor_thrusts()))
        except (EOFError, OSError):
            raise
        except Exception as error:  # noqa: BLE001  whatever it was, the parent hears of it
            pipe.send(error if isinstance(error, HotlapError) else SimulatorError(f"{type(error).__name__}: {error}"))
