"""Whatever stands in a file, a reader takes it or refuses it with one line; `make fuzz` gives each ten thousand inputs."""

from __future__ import annotations

import pytest

from fuzz.logs import LOGS
from fuzz.readers import READERS
from fuzz.trial import attempt

INPUTS = 25
ALL = {**READERS, **LOGS}
RUNS = ("log, blackbox",)  # a program for each input, which takes its time
EACH = [pytest.param(name, marks=[pytest.mark.check] if name in RUNS else []) for name in ALL]


@pytest.mark.parametrize("name", EACH)
def test_whatever_stands_in_a_file_it_is_read_or_refused_with_one_line(name, tmp_path):
    figures = attempt(name, lambda random: ALL[name].give(random, tmp_path), INPUTS, tmp_path)
    assert not figures.faults, figures.faults[0]
    assert figures.refused > 0


@pytest.mark.parametrize("name", EACH)
def test_what_is_damaged_was_read_before(name, tmp_path):
    for sample in ALL[name].samples():
        path = tmp_path / f"input{ALL[name].ending}"
        path.write_bytes(sample)
        ALL[name].read(path)
