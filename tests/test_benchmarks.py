"""Every benchmark that is a program can be started."""

import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
PROGRAMS = sorted(path.name for path in BENCHMARKS.glob("*.py") if "__main__" in path.read_text(encoding="utf-8"))


def test_there_are_some():
    assert len(PROGRAMS) > 10


@pytest.mark.check
@pytest.mark.parametrize("name", PROGRAMS)
def test_a_benchmark_says_what_it_does(name):
    told = subprocess.run([sys.executable, name, "--help"], cwd=BENCHMARKS, capture_output=True, text=True, check=False)
    if "No module named" in told.stderr and not told.stderr.rstrip().endswith("'hotlap'"):
        pytest.skip(told.stderr.rstrip().splitlines()[-1])  # one that needs what is not installed
    assert told.returncode == 0, told.stderr
    assert told.stdout.startswith("usage:")
