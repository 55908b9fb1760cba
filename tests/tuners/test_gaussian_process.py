"""Covariance, likelihood and posterior agree with scikit-learn and with finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern

from hotlap.tuners.surrogates.gaussian_process import (
    Kernel,
    Prior,
    climb,
    covariance,
    fit,
    likeliest_of,
    log_likelihood,
    log_likelihood_with_gradient,
)

RNG = np.random.default_rng(5)
POINTS = RNG.random((30, 4))
VALUES = np.sin(4 * POINTS[:, 0]) + 0.3 * POINTS[:, 1] + 0.1 * RNG.standard_normal(30)
VALUES = (VALUES - VALUES.mean()) / VALUES.std()
KERNEL = Kernel(np.array([0.4, 0.9, 1.5, 0.7]), 0.05)
ELSEWHERE = RNG.random((20, 4))
LENGTHS, NOISES = (0.005, 2.0), (5e-4, 0.2)
CONSTANT = -0.5 * len(VALUES) * (np.log(2 * np.pi) + 1)  # that `log_likelihood` leaves out


def process(kernel: Kernel, variance: float) -> GaussianProcessRegressor:
    """scikit-learn's process with the same kernel, conditioned on the same data."""
    return GaussianProcessRegressor(
        ConstantKernel(variance) * Matern(kernel.lengths, nu=2.5), alpha=variance * kernel.noise, optimizer=None
    ).fit(POINTS, VALUES)


def likelihood(kernel: Kernel, values: np.ndarray = VALUES) -> float:
    return log_likelihood(POINTS / kernel.lengths, values, kernel.noise)


def test_the_covariance_is_that_of_another_implementation():
    theirs = Matern(KERNEL.lengths, nu=2.5)(POINTS, ELSEWHERE)
    np.testing.assert_allclose(covariance(POINTS / KERNEL.lengths, ELSEWHERE / KERNEL.lengths), theirs, rtol=1e-12)


def test_the_covariance_falls_with_distance_and_is_one_at_none_in_either_precision():
    line = np.linspace(0, 8, 50)[:, None]
    kernel = covariance(line, line)
    assert kernel[0, 0] == pytest.approx(1.0)
    assert (np.diff(kernel[0]) < 0).all()
    assert np.linalg.eigvalsh(kernel).min() > -1e-9
    single = covariance(line.astype(np.float32), line.astype(np.float32))
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, kernel, atol=1e-3)


@pytest.mark.parametrize("kernel", [KERNEL, Kernel(0.8, 0.05)], ids=["a length for each axis", "one for all"])
def test_posterior_is_that_of_another_implementation(kernel):
    ours = kernel.condition(POINTS, VALUES)
    mean, deviation = process(kernel, ours.scale**2).predict(ELSEWHERE, return_std=True)
    for mine, theirs in zip(ours.predict(ELSEWHERE), (mean, deviation), strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-6)


def test_posterior_of_a_stated_process_is_that_of_another_implementation():
    prior = Prior(0.8, 1.5, 0.3)
    ours = prior.condition(POINTS, VALUES, 0.0)
    theirs = GaussianProcessRegressor(ConstantKernel(1.5**2) * Matern(0.8, nu=2.5), alpha=0.3**2, optimizer=None).fit(POINTS, VALUES)
    mean, matrix = theirs.predict(ELSEWHERE, return_cov=True)
    np.testing.assert_allclose(ours.predict(ELSEWHERE)[0], mean, rtol=1e-6)
    np.testing.assert_allclose(ours.covariance(ELSEWHERE, ELSEWHERE), matrix, atol=1e-9)


def test_columns_of_values_are_processes_of_their_own_that_share_a_kernel():
    columns = np.column_stack([VALUES, 3 * VALUES[::-1] + 2])
    together = fit(POINTS / KERNEL.lengths, columns, KERNEL.noise, lengths=KERNEL.lengths)
    alone = [KERNEL.condition(POINTS, column) for column in columns.T]
    for kind in (0, 1):
        expected = np.column_stack([each.predict(ELSEWHERE)[kind] for each in alone])
        np.testing.assert_allclose(together.predict(ELSEWHERE)[kind], expected, rtol=1e-9)
    centred = columns - columns.mean(axis=0)
    assert likelihood(KERNEL, centred) == pytest.approx(sum(likelihood(KERNEL, column) for column in centred.T))


def test_single_precision_is_enough_for_a_thousandth():
    posterior = KERNEL.condition(POINTS, VALUES)
    single = posterior.in_single_precision()
    assert single.across(ELSEWHERE).dtype == np.float32
    for rough, fine in zip(single.predict(ELSEWHERE), posterior.predict(ELSEWHERE), strict=True):
        np.testing.assert_allclose(rough, fine, atol=2e-3)


def test_likelihood_is_that_of_another_implementation_at_the_best_variance():
    best = KERNEL.condition(POINTS, VALUES).scale ** 2
    ours = likelihood(KERNEL) + CONSTANT
    assert ours == pytest.approx(process(KERNEL, best).log_marginal_likelihood_value_, rel=1e-9)
    assert all(ours > process(KERNEL, best * factor).log_marginal_likelihood_value_ for factor in (0.8, 1.25))


@pytest.mark.parametrize(("count", "size", "columns"), [(3, 1, 1), (40, 5, 1), (60, 35, 1), (40, 5, 3)])
def test_gradient_is_that_of_finite_differences(count, size, columns):
    rng = np.random.default_rng(size)
    points, values = rng.random((count, size)), rng.standard_normal((count, columns))
    at, step = np.append(np.log(rng.uniform(0.2, 2, size)), np.log(0.03)), 1e-5

    def height(logarithms):
        return log_likelihood(points / np.exp(logarithms[:-1]), values, np.exp(logarithms[-1]))

    numeric = [(height(at + step * axis) - height(at - step * axis)) / (2 * step) for axis in np.eye(size + 1)]
    found, gradient = log_likelihood_with_gradient(points, values, at)
    np.testing.assert_allclose(gradient, numeric, rtol=1e-5, atol=1e-6)
    assert found == pytest.approx(height(at), rel=1e-9)


def test_the_climb_ends_where_another_one_does():
    found = climb(POINTS, VALUES, Kernel(0.5, 0.005), LENGTHS, NOISES)
    variance = found.condition(POINTS, VALUES).scale ** 2
    free = ConstantKernel(1.0, (1e-3, 1e3)) * Matern(np.full(4, 0.5), [LENGTHS] * 4, nu=2.5)
    with pytest.warns(ConvergenceWarning, match="close to the specified upper bound 2"):
        peer = GaussianProcessRegressor(free, alpha=variance * found.noise).fit(POINTS, VALUES)
    assert likelihood(found) + CONSTANT == pytest.approx(peer.log_marginal_likelihood_value_, abs=0.1)


def test_the_likeliest_of_a_grid_is_no_less_likely_than_any_of_it():
    lengths, noises = (0.2, 0.8, 3.0), (0.01, 0.1)
    grid = {(length, noise): likelihood(Kernel(length, noise)) for length in lengths for noise in noises}
    found = likeliest_of(POINTS, 5 * VALUES + 3, lengths, noises)
    assert (found.lengths, found.noise) == max(grid, key=grid.__getitem__)


def test_an_axis_that_matters_is_short_and_one_that_does_not_is_long():
    rng = np.random.default_rng(1)
    points = rng.random((80, 10))
    lengths = climb(points, np.sin(5 * points[:, 3]), Kernel(0.5, 0.005), LENGTHS, NOISES).lengths
    assert np.argmin(lengths) == 3
    assert np.median(lengths) > 3 * lengths[3]


def test_values_that_are_all_alike_have_a_kernel_too():
    found = climb(POINTS, np.full(30, 7.0), Kernel(0.5, 0.005), LENGTHS, NOISES)
    assert np.isfinite([*found.lengths, found.noise]).all()
    np.testing.assert_allclose(found.condition(POINTS, np.full(30, 7.0)).predict(ELSEWHERE)[0], 7.0)
