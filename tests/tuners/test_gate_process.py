"""Gate processes know what causes what, and what they do not know."""

from __future__ import annotations

import numpy as np

from hotlap.tuners.surrogates.gate_process import (
    FARTHEST,
    NEAREST,
    ROWS,
    GateKernel,
    Group,
    climb_at_random,
    condition,
    gate_groups,
    log_posterior,
)
from hotlap.tuners.surrogates.gaussian_process import covariance

SEGMENTS, SIZE = 3, 2
GATE_SEGMENTS = np.array([0, 0, 1, 2])


def flights(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Points, and misses that depend on the parameters of each gate's own segment alone, shape (count, 4)."""
    points = np.random.default_rng(seed).uniform(-2, 2, (count, SEGMENTS, SIZE))
    return points, 0.2 * (points[:, GATE_SEGMENTS] ** 2).sum(axis=2) - 0.8


def learnt(count: int = 60, seed: int = 0):
    points, misses = flights(count, seed)
    groups = gate_groups(misses, GATE_SEGMENTS)
    return condition(points, groups, climb_at_random(points, groups, GateKernel.prior(SIZE), 60, np.random.default_rng(1)))


def test_it_predicts_flights_that_it_has_not_seen():
    points, misses = flights(200, seed=5)
    means, deviations, noises = learnt().predict(points)
    assert np.sqrt(((means - misses) ** 2).mean()) < 0.5 * misses.std()
    assert noises.shape == (4,)
    assert ((means - misses) ** 2).mean() < 4 * (deviations**2 + noises**2).mean()


def test_what_is_flown_later_does_not_matter_to_a_gate():
    points = flights(20, seed=5)[0]
    changed = points.copy()
    changed[:, 1:] += 1.0
    before, after = learnt().predict(points), learnt().predict(changed)
    for kind in (0, 1):
        np.testing.assert_array_equal(before[kind][:, :2], after[kind][:, :2])
        assert not np.allclose(before[kind][:, 2:], after[kind][:, 2:])


def test_points_that_move_alike_are_as_far_apart_for_every_gate():
    points = np.tile(np.random.default_rng(0).standard_normal((5, 1, SIZE)), (1, SEGMENTS, 1))
    shape = GateKernel.prior(SIZE)
    kernels = [covariance(features, features) for features in (shape.features(points, segment) for segment in (0, 1, 2, None))]
    for kernel in kernels[1:]:
        np.testing.assert_allclose(kernel, kernels[0], rtol=1e-12)


def test_a_climb_never_ends_lower_and_finds_the_length_that_matters():
    points = np.random.default_rng(0).uniform(-2, 2, (80, 1, 2))
    groups = [Group(None, np.arange(1), np.arange(80), np.sin(3 * points[:, 0, :1]))]
    start = GateKernel.prior(2)
    found = climb_at_random(points, groups, start, 200, np.random.default_rng(3))
    assert log_posterior(points, groups, found) > log_posterior(points, groups, start)
    matters, does_not = np.exp(found.numbers[:2])
    assert does_not > 2 * matters
    assert climb_at_random(points, groups, start, 0, np.random.default_rng(3)) is start


def test_it_returns_to_the_values_where_they_say_something_and_to_doubt_elsewhere():
    points, misses = flights(40)
    groups = gate_groups(misses, GATE_SEGMENTS)
    posterior = condition(points, groups, GateKernel(np.array([0.0, 0.0, -3.0, np.log(1e-3)])))
    means, deviations, _ = posterior.predict(points)
    np.testing.assert_allclose(means[:, :2], misses[:, :2], atol=0.1)
    assert deviations[:, 0].max() < 0.3 * posterior.predict(points + 50)[1][:, 0].min()


def test_a_gate_that_was_not_reached_teaches_nothing_and_one_behind_a_reached_one_counts_as_far():
    misses = np.array([[0.1, np.nan, np.nan, np.nan], [-9.0, 0.2, 0.3, np.nan], [0.4, 9.0, 0.3, np.nan]])
    first, second, third = gate_groups(misses, GATE_SEGMENTS)
    assert (first.rows.tolist(), second.rows.tolist(), third.rows.tolist()) == ([0, 1, 2], [1, 2], [])
    np.testing.assert_allclose(first.values, [[0.1, FARTHEST], [NEAREST, 0.2], [0.4, FARTHEST]])
    means, deviations, noises = condition(flights(3)[0], [first, second, third], GateKernel.prior(SIZE)).predict(flights(7)[0])
    assert np.isfinite(means).all()
    assert (deviations > 0).all()
    assert (noises > 0).all()
    assert np.ptp(means[:, 3]) == 0, "nothing is known of the last gate"


def test_the_likelihood_is_asked_about_the_latest_flights_alone():
    points, misses = flights(ROWS + 50)
    old = misses.copy()
    old[:50] = np.random.default_rng(8).standard_normal((50, 4))
    start, seeds = GateKernel.prior(SIZE), (np.random.default_rng(4), np.random.default_rng(4))
    found = [
        climb_at_random(points, gate_groups(each, GATE_SEGMENTS), start, 10, rng) for each, rng in zip((misses, old), seeds, strict=True)
    ]
    np.testing.assert_array_equal(found[0].numbers, found[1].numbers)
    assert not np.array_equal(found[0].numbers, start.numbers)
