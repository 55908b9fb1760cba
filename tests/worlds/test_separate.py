"""A simulator in a process of its own is the simulator, and says so when it is lost."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

from hotlap.worlds.separate import Separate
from hotlap.worlds.simulator import SimulatorError, Start

START = Start(np.arange(13.0), 1.1)


class Recorder:
    """Two drones that are where they were placed, further on in x by every duration; may refuse, or die."""

    def __init__(self, manner: str = "well") -> None:
        if manner == "closed":
            raise SimulatorError("there is no such drone")
        self.lanes, self.step, self.scales_thrust = 2, 0.005, True
        self._manner, self._states, self._factors = manner, np.zeros((2, 13)), np.ones(2)

    def reset(self, lane: int, start: Start) -> None:
        self._states[lane], self._factors[lane] = start.state, start.thrust_factor

    def advance(self, commands: np.ndarray, duration: float) -> None:
        if self._manner == "dies":
            os._exit(3)
        if self._manner == "fails":
            raise ZeroDivisionError("by its mass")
        self._states[:, 0] += duration * commands[:, 0]

    def states(self) -> np.ndarray:
        return self._states

    def rotor_thrusts(self) -> np.ndarray:
        return np.tile(self._factors[:, None], 4)

    def close(self) -> None:
        pass


def test_it_does_what_the_simulator_does():
    simulator = Separate(Recorder)
    assert (simulator.lanes, simulator.step, simulator.scales_thrust) == (2, 0.005, True)
    simulator.reset(1, START)
    simulator.advance(np.array([[1.0, 0, 0, 0], [2.0, 0, 0, 0]]), 0.01)
    np.testing.assert_allclose(simulator.states(), [[0.01, *np.zeros(12)], [0.02, *np.arange(1.0, 13)]])
    np.testing.assert_allclose(simulator.rotor_thrusts()[:, 0], [1.0, 1.1])
    simulator.close()
    simulator.close()


@pytest.mark.parametrize(("manner", "says"), [("dies", "process has ended"), ("fails", "ZeroDivisionError: by its mass")])
def test_one_that_is_lost_says_so(manner, says):
    simulator = Separate(Recorder, manner)
    with pytest.raises(SimulatorError, match=says):
        simulator.advance(np.zeros((2, 4)), 0.01)
    simulator.close()
    with pytest.raises(SimulatorError, match="process has ended"):
        simulator.reset(0, START)


def test_one_that_cannot_be_opened_says_why():
    with pytest.raises(SimulatorError, match="there is no such drone"):
        Separate(Recorder, "closed")


def test_nothing_of_the_folder_that_it_runs_in_is_loaded(tmp_path, monkeypatch):
    (tmp_path / "numpy.py").write_text("raise SystemExit('loaded')\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [path for path in sys.path if path])
    simulator = Separate(Recorder)
    assert simulator.lanes == 2
    simulator.close()


def test_a_program_needs_no_guard(tmp_path):
    """Nothing of it is loaded again for the simulator's process."""
    (tmp_path / "simple.py").write_text(
        "from hotlap.worlds.separate import Separate\nfrom worlds.test_separate import Recorder\nprint('once', Separate(Recorder).lanes)\n"
    )
    ran = subprocess.run([sys.executable, "simple.py"], cwd=tmp_path, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
                         capture_output=True, text=True, check=False)  # fmt: skip
    assert (ran.stdout, ran.stderr) == ("once 2\n", "")
