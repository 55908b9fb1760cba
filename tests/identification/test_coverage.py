"""Of a hundred vehicles and noises, nine in ten intervals hold the truth, and every number is within five per cent."""

from __future__ import annotations

import pytest

from hotlap.identification.identify import identify
from identification.flights import BASE, TOLD, WITHIN, drawn, errors

DRAWS, LEAST = 100, 90


@pytest.mark.slow
def test_intervals_cover_the_truth():
    covered = dict.fromkeys([*TOLD, "drag x", "drag y", "drag z"], 0)
    for seed in range(DRAWS):
        truth = drawn(seed)
        found = identify([truth.fly(seed)], BASE, thrust_known=True)
        assert {name: off for name, off in errors(found, truth).items() if name in TOLD and off > WITHIN} == {}
        for one in found.estimates:
            if one.name in covered:
                covered[one.name] += one.low <= truth.numbers[one.name] <= one.high
    assert {name: held for name, held in covered.items() if held < LEAST} == {}
