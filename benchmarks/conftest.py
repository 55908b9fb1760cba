"""Print the machine of the benchmarks, and the figures that they record besides times."""

from __future__ import annotations

import pytest

from hotlap.analysis.speed import RACE, machine_name
from hotlap.planning.preparation import prepare
from hotlap.reference.scenario import Scenario


def pytest_benchmark_update_machine_info(machine_info):
    machine_info["processor"] = machine_name()


def pytest_terminal_summary(terminalreporter, config):
    terminalreporter.write_line(f"machine: {machine_name()}")
    for bench in config._benchmarksession.benchmarks:
        if bench.extra_info:
            figures = (f"{name} {value:.4g}" if isinstance(value, float) else f"{name} {value}" for name, value in bench.extra_info.items())
            terminalreporter.write_line(f"  {bench.name}: {', '.join(figures)}")


@pytest.fixture(scope="session")
def scenario() -> Scenario:
    return prepare(RACE)
