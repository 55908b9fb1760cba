"""Time of commands in a new process with filled caches; and of the first flight on a machine, with empty caches."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

COMMANDS = ["--help", "races", "check circle-34", "fly circle-34 --flights 8"]


def call(command: str, **environment: str) -> None:
    arguments = [sys.executable, "-m", "hotlap", *command.split()]
    subprocess.run(arguments, capture_output=True, check=True, env={**os.environ, **environment})


@pytest.mark.parametrize("command", COMMANDS)
def test_command(benchmark, command):
    benchmark.pedantic(call, (command,), rounds=5, warmup_rounds=1)


def test_first_flight_of_all(benchmark, tmp_path):
    benchmark.pedantic(call, ("fly circle-34 --flights 8",), {"HOTLAP_CACHE": str(tmp_path)}, rounds=1)
