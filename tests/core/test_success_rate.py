"""A validation is reported with Wilson's interval."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hotlap.core.success_rate import Validation, wilson_interval


@pytest.mark.parametrize(
    ("successes", "flights", "low", "high"),
    [  # Newcombe, Statistics in Medicine 17 (1998), Table I, method 3
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
        (29, 29, 0.8830, 1.0),
    ],
)
def test_wilson_interval_equals_published_values(successes, flights, low, high):
    assert wilson_interval(successes, flights) == pytest.approx((low, high), abs=5e-5)


@given(st.integers(1, 2000).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_interval_holds_the_rate_and_is_mirrored_for_failures(counts):
    successes, flights = counts
    low, high = wilson_interval(successes, flights)
    assert 0 <= low <= successes / flights <= high <= 1
    assert (1 - high, 1 - low) == pytest.approx(wilson_interval(flights - successes, flights), abs=1e-12)


def test_interval_of_a_validation_is_wilsons():
    assert Validation(263, 81).interval == wilson_interval(81, 263)
