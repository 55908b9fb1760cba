"""Statistics agree with values worked out by hand, and bear runs that never ended."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hotlap.analysis.statistics import (
    bootstrap_interval,
    means,
    medians,
    performance_profile,
    performance_ratios,
    quantile,
    quartiles,
)

INF = math.inf
FLIGHTS = st.lists(st.floats(1, 1000) | st.just(INF), min_size=1, max_size=20).map(np.array)


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=20), st.floats(0, 1))
def test_finite_quantiles_are_numpys(values, share):
    assert quantile(np.array(values), share) == pytest.approx(np.quantile(values, share), abs=1e-9)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([1, 2, 3, 4, 5], (2, 3, 4)),
        ([5, 1, INF, 2, INF], (2, 5, INF)),
        ([1, 2, 3, INF], (1.75, 2.5, INF)),
        ([1, 2, INF, INF], (1.75, INF, INF)),
        ([INF], (INF, INF, INF)),
        ([7], (7, 7, 7)),
    ],
)
def test_runs_without_an_end_count_as_the_longest(values, expected):
    assert quartiles(np.array(values, dtype=float)) == expected


@given(FLIGHTS)
def test_quartiles_are_in_order_and_the_median_is_that_of_the_bootstrap(values):
    low, middle, high = quartiles(values)
    assert low <= middle <= high
    assert middle == pytest.approx(medians(values[None])[0])


def test_the_interval_of_a_mean_is_that_of_the_normal_law():
    values = np.random.default_rng(1).normal(3, 2, 400)
    low, high = bootstrap_interval(values, means)
    half_width = 1.96 * values.std() / 20
    assert (low, high) == pytest.approx((values.mean() - half_width, values.mean() + half_width), abs=0.02)


def test_the_interval_of_a_rate_covers_what_the_binomial_law_does():
    low, high = bootstrap_interval(np.repeat([0.0, 1.0], [6, 14]), means)
    assert (low, high) == (0.5, 0.9)  # of 20 draws at 0.7: 10 and 18 are the 2.5 % and 97.5 % points


@given(FLIGHTS)
def test_an_interval_lies_among_the_values_and_is_the_same_again(values):
    low, high = bootstrap_interval(values, medians, seed=3)
    assert values.min() <= low <= high <= values.max()
    assert (low, high) == bootstrap_interval(values, medians, seed=3)


def test_more_runs_narrow_an_interval():
    few, many = (bootstrap_interval(np.tile([10.0, 20, 30, 40], count), medians) for count in (2, 50))
    assert many[1] - many[0] < few[1] - few[0]


def test_ratios_are_to_the_best_on_each_problem():
    costs = np.array([[10.0, 50, INF, INF], [20.0, 25, INF, 9]])
    np.testing.assert_array_equal(performance_ratios(costs), [[1, 2, INF, INF], [2, 1, INF, 1]])


def test_a_profile_begins_with_the_share_of_wins_and_ends_with_that_of_successes():
    ratios = np.array([[1, 2, INF, INF], [2, 1, INF, 1]])
    np.testing.assert_array_equal(
        performance_profile(ratios, np.array([1, 1.99, 2, 1e9])), [[0.25, 0.25, 0.5, 0.5], [0.5, 0.5, 0.75, 0.75]]
    )


@given(st.integers(1, 4), st.integers(1, 6), st.integers(0, 1000))
def test_profiles_rise_and_someone_wins_each_problem_that_was_solved(solvers, problems, seed):
    rng = np.random.default_rng(seed)
    costs = np.where(rng.random((solvers, problems)) < 0.3, INF, rng.integers(1, 100, (solvers, problems)))
    shares = performance_profile(performance_ratios(costs), np.array([1, 2, 10, 1e9]))
    assert (np.diff(shares, axis=1) >= 0).all()
    np.testing.assert_allclose(shares[:, -1], np.isfinite(costs).mean(axis=1))
    assert shares[:, 0].sum() >= np.isfinite(costs).any(axis=0).mean() - 1e-9
