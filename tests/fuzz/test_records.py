"""Damaged studies, journals and replies of simulators: read, continued, or refused with one line."""

from __future__ import annotations

import pytest

from fuzz.records import RECORDS
from fuzz.trial import attempt
from fuzz.wires import WIRES

GIVEN = {**RECORDS, **WIRES}
LONG = {"study.sqlite, bytes": 2000, "study.sqlite, values": 1000, "runs.jsonl": 1000, "lines.jsonl": 1000}


@pytest.mark.parametrize("name", GIVEN)
def test_whatever_is_damaged_it_is_said_in_one_line(name, tmp_path):
    figures = attempt(name, lambda random: GIVEN[name].give(random, tmp_path), 12, tmp_path)
    assert not figures.faults, figures.faults[0]


@pytest.mark.check
@pytest.mark.parametrize("name", LONG)
def test_thousands_of_them(name, tmp_path):
    figures = attempt(name, lambda random: GIVEN[name].give(random, tmp_path), LONG[name], tmp_path)
    assert not figures.faults, figures.faults[0]
