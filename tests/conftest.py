"""Hypothesis without clocks and without luck, linear algebra on one thread, and kernels compiled while the workers still look for tests."""

from __future__ import annotations

import subprocess
import sys

import pytest
from hypothesis import settings

from hotlap.system.blas_threads import one_thread

one_thread()

settings.register_profile("hotlap", deadline=None, derandomize=True, max_examples=60)
settings.load_profile("hotlap")

COMPILE = """
import sys
from hotlap.flight.self_check import make_scenario
from hotlap.race.controller_kind import ControllerKind
from hotlap.worlds.built_in import BuiltIn
world, scenario = BuiltIn(sys.argv[1]), make_scenario(ControllerKind.MPC)
if world.needs_compiling(scenario):
    world.prepare(scenario)
"""


def pytest_configure(config: pytest.Config) -> None:
    """Where all tests are run by several workers, compile what they would otherwise wait for, lanes and plain floats side by side.

    A worker that needs a kernel that is under way waits for it (`flight.kernel_cache`); where nothing is to be compiled this ends at once.
    """
    everything = config.args == config.getini("testpaths") and getattr(config.option, "numprocesses", None)
    if everything and not hasattr(config, "workerinput"):
        quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        for numbers in ("", "float64"):
            subprocess.Popen([sys.executable, "-c", COMPILE, numbers], **quiet)
