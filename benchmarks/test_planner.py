"""Time of planning without the cache."""

from __future__ import annotations

import pytest

from hotlap.files.descriptions import load_race
from hotlap.planning import plan


@pytest.mark.parametrize("name", ["circle-34", "qualifier-20", "final-22", "split-s"])
def test_plan(benchmark, name):
    reference = benchmark.pedantic(plan, (load_race(name),), {"cache": False}, rounds=3)
    benchmark.extra_info |= {"duration": reference.duration, "CPU seconds": reference.cpu_time}
