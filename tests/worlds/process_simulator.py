"""A simulator that is a process of its own, asked over pipes, each answer within a time-out: how simulators are attached from outside."""

from __future__ import annotations

import json
import select
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np

from hotlap.worlds.simulator import SimulatorError, Start

PROGRAM, STEP = Path(__file__).with_name("drone_process.py"), 0.0025
LONG, SHORT = 120.0, 5.0  # s: a busy machine is no failure; one that hangs need not be waited for


class ProcessSimulator:
    """A drone in `drone_process.py`.

    Args:
        manner: how the program behaves: its arguments.
    """

    lanes, step, scales_thrust = 1, STEP, False

    def __init__(self, *manner: str) -> None:
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        self.process = subprocess.Popen([sys.executable, "-S", str(PROGRAM), *(manner or ["well"])], **pipes)
        self._state, self.timeout = np.zeros(13), SHORT if "hangs" in manner else LONG

    def reset(self, _lane: int, start: Start) -> None:
        self._ask({"state": start.state.tolist()})

    def advance(self, commands: np.ndarray, duration: float) -> None:
        self._ask({"command": commands[0].tolist(), "steps": round(duration / STEP)})

    def states(self) -> np.ndarray:
        return self._state[None]

    def rotor_thrusts(self) -> np.ndarray:
        return np.full((1, 4), np.nan)

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        with suppress(OSError):
            self.process.stdin.close()
        self.process.stdout.close()

    def _ask(self, what: dict) -> None:
        try:
            self.process.stdin.write(json.dumps(what).encode() + b"\n")
            self.process.stdin.flush()
        except OSError as error:
            raise SimulatorError("the simulator has ended") from error
        if not select.select([self.process.stdout], [], [], self.timeout)[0]:
            raise SimulatorError(f"the simulator has not answered for {self.timeout:g} s")
        line = self.process.stdout.readline()
        if not line:
            raise SimulatorError("the simulator has ended")
        try:
            self._state = np.array(json.loads(line), dtype=np.float64)
        except ValueError as error:
            raise SimulatorError(f"the simulator answers what nobody understands: {line[:20]!r}") from error
