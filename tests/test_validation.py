"""A validation is flown with noise of its own and reported with Wilson's interval."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fake_world import OPTIMUM, FakeWorld, make_course
from hotlap.goal import parse_goal
from hotlap.objective import Objective
from hotlap.seeds import Stream, flight_seeds
from hotlap.validation import Validation, validate, wilson_interval


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


def test_successes_are_the_flights_that_meet_the_goal():
    objective = Objective(make_course(), FakeWorld(noise=0.9))
    parameters = np.tile(OPTIMUM, (2, 1))
    validation, ledger = validate(objective, parse_goal("completion=1"), parameters, seed=5, flights=300)
    assert 0 < validation.successes < 300
    assert validation.successes == (ledger.completion == 1).sum()
    assert validation.rate == validation.successes / 300
    assert objective.flights == 300
    strict, _ = validate(objective, parse_goal("mean_error<0.5"), parameters, seed=5, flights=300)
    assert strict.successes < validation.successes


def test_noise_is_that_of_the_validation_stream():
    _, ledger = validate(Objective(make_course(), FakeWorld()), parse_goal("none"), np.tile(OPTIMUM, (2, 1)), seed=5, flights=10)
    np.testing.assert_array_equal(ledger.seeds, flight_seeds(5, Stream.VALIDATION, 0, 10))
    assert (ledger.streams == Stream.VALIDATION).all()


def test_interval_of_a_validation_is_wilsons():
    assert Validation(263, 81).interval == wilson_interval(81, 263)
