"""Which machine the figures are of."""

from __future__ import annotations

import pytest

from hotlap.bench import RACE, machine_name
from hotlap.course import Course
from hotlap.preparation import prepare


def pytest_report_header() -> str:
    return f"machine: {machine_name()}"


def pytest_benchmark_update_machine_info(machine_info):
    machine_info["processor"] = machine_name()


@pytest.fixture(scope="session")
def course() -> Course:
    return prepare(RACE)
