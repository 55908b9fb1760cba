"""Whatever stands in a file, a reader takes it or refuses it with one line; `make fuzz` gives each ten thousand inputs."""

from __future__ import annotations

import pytest

from fuzz.readers import READERS
from fuzz.trial import attempt

INPUTS = 25


@pytest.mark.parametrize("name", READERS)
def test_whatever_stands_in_a_file_it_is_read_or_refused_with_one_line(name, tmp_path):
    figures = attempt(name, lambda random: READERS[name].give(random, tmp_path), INPUTS, tmp_path)
    assert not figures.faults, figures.faults[0]
    assert figures.refused > 0


@pytest.mark.parametrize("name", READERS)
def test_what_is_damaged_was_read_before(name, tmp_path):
    for sample in READERS[name].samples():
        path = tmp_path / f"input{READERS[name].ending}"
        path.write_bytes(sample)
        READERS[name].read(path)
