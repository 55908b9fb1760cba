"""Likelihood, posterior and drawn functions agree with scikit-learn, with finite differences and with each other."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern

from hotlap.tuners.surrogates.anisotropic_process import LENGTHS, Kernel, draw_paths, log_likelihood, most_likely

RNG = np.random.default_rng(5)
POINTS = RNG.random((30, 4))
VALUES = np.sin(4 * POINTS[:, 0]) + 0.3 * POINTS[:, 1] + 0.1 * RNG.standard_normal(30)
VALUES = (VALUES - VALUES.mean()) / VALUES.std()
KERNEL = Kernel(np.array([0.4, 0.9, 1.5, 0.7]), 0.05)
ELSEWHERE = RNG.random((20, 4))


def process(kernel: Kernel, variance: float) -> GaussianProcessRegressor:
    """scikit-learn's process with the same kernel, conditioned on the same data."""
    product = ConstantKernel(variance) * Matern(kernel.lengths, nu=2.5)
    return GaussianProcessRegressor(product, alpha=variance * kernel.noise, optimizer=None).fit(POINTS, VALUES)


def test_posterior_is_that_of_another_implementation():
    ours = KERNEL.condition(POINTS, VALUES)
    mean, deviation = process(KERNEL, ours.scale**2).predict(ELSEWHERE, return_std=True)
    for mine, theirs in zip(ours.predict(ELSEWHERE / KERNEL.lengths), (mean, deviation), strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-6)


def test_likelihood_is_that_of_another_implementation_at_the_best_variance():
    best = KERNEL.condition(POINTS, VALUES).scale ** 2
    ours = log_likelihood(POINTS, VALUES, np.log([*KERNEL.lengths, KERNEL.noise]))[0]
    assert ours == pytest.approx(process(KERNEL, best).log_marginal_likelihood_value_, rel=1e-9)
    assert all(ours > process(KERNEL, best * factor).log_marginal_likelihood_value_ for factor in (0.8, 1.25))


@pytest.mark.parametrize(("count", "size"), [(3, 1), (40, 5), (60, 35)])
def test_gradient_is_that_of_finite_differences(count, size):
    rng = np.random.default_rng(size)
    points, values = rng.random((count, size)), rng.standard_normal(count)
    at, step = np.append(np.log(rng.uniform(0.2, 2, size)), np.log(0.03)), 1e-5
    numeric = [
        (log_likelihood(points, values, at + step * axis)[0] - log_likelihood(points, values, at - step * axis)[0]) / (2 * step)
        for axis in np.eye(size + 1)
    ]
    np.testing.assert_allclose(log_likelihood(points, values, at)[1], numeric, rtol=1e-5, atol=1e-6)


def test_the_climb_ends_where_another_one_does():
    found = most_likely(POINTS, VALUES, Kernel(np.full(4, 0.5), 0.005))
    ours = log_likelihood(POINTS, VALUES, np.log([*found.lengths, found.noise]))[0]
    variance = found.condition(POINTS, VALUES).scale ** 2
    free = ConstantKernel(1.0, (1e-3, 1e3)) * Matern(np.full(4, 0.5), [LENGTHS] * 4, nu=2.5)
    with pytest.warns(ConvergenceWarning, match="close to the specified upper bound 2"):
        peer = GaussianProcessRegressor(free, alpha=variance * found.noise).fit(POINTS, VALUES)
    assert ours == pytest.approx(peer.log_marginal_likelihood_value_, abs=0.1)


def test_an_axis_that_matters_is_short_and_one_that_does_not_is_long():
    rng = np.random.default_rng(1)
    points = rng.random((80, 10))
    lengths = most_likely(points, np.sin(5 * points[:, 3]), Kernel(np.full(10, 0.5), 0.005)).lengths
    assert np.argmin(lengths) == 3
    assert np.median(lengths) > 3 * lengths[3]


def test_values_that_are_all_alike_have_a_kernel_too():
    found = most_likely(POINTS, np.full(30, 7.0), Kernel(np.full(4, 0.5), 0.005))
    assert np.isfinite([*found.lengths, found.noise]).all()
    np.testing.assert_allclose(found.condition(POINTS, np.full(30, 7.0)).predict(ELSEWHERE / found.lengths)[0], 7.0)


def test_drawn_functions_have_the_posterior_s_mean_and_deviation():
    posterior, rng = KERNEL.condition(POINTS, VALUES), np.random.default_rng(2)
    drawn = np.hstack([draw_paths(posterior, KERNEL.noise, 20, rng).at(ELSEWHERE / KERNEL.lengths) for _ in range(200)])
    mean, deviation = posterior.predict(ELSEWHERE / KERNEL.lengths)
    np.testing.assert_allclose(drawn.mean(axis=1), mean, atol=0.1 * deviation.max())
    np.testing.assert_allclose(drawn.std(axis=1), deviation, rtol=0.08)


def test_drawn_functions_pass_through_data_without_noise_and_differ_elsewhere():
    exact = Kernel(KERNEL.lengths, 1e-6)
    paths = draw_paths(exact.condition(POINTS, VALUES), exact.noise, 2, np.random.default_rng(3))
    np.testing.assert_allclose(paths.at(POINTS / exact.lengths), np.repeat(VALUES[:, None], 2, axis=1), atol=0.02)
    apart = paths.at(ELSEWHERE / exact.lengths)
    assert np.abs(apart[:, 0] - apart[:, 1]).max() > 0.1
