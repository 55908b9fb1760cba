"""Plain JSON that is read back holds what a record of ours says."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from hotlap.core.errors import InputError
from hotlap.core.plain import typed, value_of


@dataclass
class Record:
    flights: int
    cost: float
    confirmed: bool
    name: str


GOOD = {"flights": 3, "cost": 0.5, "confirmed": True, "name": "one"}


def test_what_is_of_its_kind_is_given_back_as_it_is():
    assert typed(Record, GOOD) == GOOD
    assert value_of("float", "cost", 1) == 1


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("flights", 3.0),
        ("flights", True),
        ("flights", [3]),
        ("cost", "0.5"),
        ("cost", None),
        ("cost", False),
        ("confirmed", 1),
        ("confirmed", {}),
    ],
)
def test_what_is_not_is_refused_by_its_name(key, value):
    with pytest.raises(InputError, match=f"{key}: must be of the kind "):
        typed(Record, {**GOOD, key: value})
