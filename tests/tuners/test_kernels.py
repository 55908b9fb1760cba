"""Every kernel is a covariance in any number of axes, has the slopes that it says, and is the textbook's."""

import numpy as np
import pytest
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process import kernels as theirs

from hotlap.tuners.bayesian import PRESETS
from hotlap.tuners.surrogates.kernels import (
    KERNELS,
    Matern,
    Periodic,
    RationalQuadratic,
    SquaredExponential,
    condition,
    covariance_of,
    likeliest,
)

EVERY = pytest.mark.parametrize("name", KERNELS)
SIZES = pytest.mark.parametrize("size", [1, 5, 35])


def points(count=60, size=5, seed=0):
    return np.random.default_rng(seed).random((count, size))


def at(name, length=None, period=None):
    """A kernel with hyperparameters in the midst of their ranges, or as given."""
    kernel = KERNELS[name]()
    for key in kernel.get_params():
        if key.endswith("length") and length is not None:
            kernel.set_params(**{key: length})
        if key.endswith("period") and period is not None:
            kernel.set_params(**{key: period})
    return kernel


@SIZES
@EVERY
@pytest.mark.parametrize("length", [0.3, 2.0])
@pytest.mark.parametrize("period", [0.3, 1.0, 3.0])
def test_gram_matrices_are_positive_semidefinite(name, size, length, period):
    gram = at(name, length, period)(points(150, size))
    np.testing.assert_allclose(gram, gram.T, atol=1e-12)
    assert np.linalg.eigvalsh(gram).min() >= -1e-9


@pytest.mark.parametrize("size", [5, 35])
def test_the_periodic_kernel_of_the_euclidean_distance_is_not(size):
    gram = theirs.ExpSineSquared(length_scale=1.0, periodicity=1.0)(points(150, size))
    assert np.linalg.eigvalsh(gram).min() < -0.1


@EVERY
def test_is_one_at_a_point_and_less_elsewhere_the_same_in_blocks(name):
    kernel, a, b = at(name), points(9), points(7, seed=1)
    np.testing.assert_allclose(np.diag(kernel(a)), kernel.diag(a), atol=1e-12)
    np.testing.assert_allclose(kernel.diag(a), 1.0)
    np.testing.assert_allclose(kernel(np.vstack([a, b]))[:9, 9:], kernel(a, b), atol=1e-12)
    assert (kernel(a, b) < 1).all()


@EVERY
def test_knows_only_differences(name):
    kernel, a = at(name), points()
    np.testing.assert_allclose(kernel(a + 0.37), kernel(a), atol=1e-10)


@SIZES
@EVERY
@pytest.mark.parametrize("seed", range(3))
def test_slopes_along_the_logarithms_of_hyperparameters_are_those_of_finite_differences(name, size, seed):
    covariance, a, h = covariance_of(name), points(12, size), 1e-5
    theta = covariance.theta + np.random.default_rng(seed).uniform(-0.5, 0.5, len(covariance.theta))
    slopes = covariance.clone_with_theta(theta)(a, eval_gradient=True)[1]
    assert slopes.shape == (12, 12, len(theta))
    for i, step in enumerate(h * np.eye(len(theta))):
        difference = covariance.clone_with_theta(theta + step)(a) - covariance.clone_with_theta(theta - step)(a)
        np.testing.assert_allclose(slopes[..., i], difference / (2 * h), atol=1e-8)


@SIZES
@pytest.mark.parametrize("length", [0.1, 0.5, 3.0])
@pytest.mark.parametrize(
    ("ours", "textbook"),
    [
        (Matern, lambda scale: theirs.Matern(scale, nu=2.5)),
        (SquaredExponential, theirs.RBF),
        (lambda length: RationalQuadratic(length, 0.7), lambda scale: theirs.RationalQuadratic(scale, alpha=0.7)),
    ],
    ids=["matern", "squared_exponential", "rational_quadratic"],
)
def test_is_that_of_scikit_learn_with_lengths_in_units_of_sqrt_d(ours, textbook, length, size):
    a, b = points(40, size), points(30, size, seed=1)
    np.testing.assert_allclose(ours(length)(a, b), textbook(length * np.sqrt(size))(a, b), atol=1e-12)


@SIZES
@pytest.mark.parametrize("period", [0.3, 1.0, 4.0])
def test_periodic_is_the_product_of_the_textbooks_over_the_axes(size, period):
    a, b = points(20, size), points(30, size, seed=1)
    one = theirs.ExpSineSquared(0.6 * np.sqrt(size), period)
    product = np.prod([one(a[:, [j]], b[:, [j]]) for j in range(size)], axis=0)
    np.testing.assert_allclose(Periodic(0.6, period)(a, b), product, atol=1e-12)


def test_periodic_returns_after_a_period_on_any_axis_and_locally_periodic_fades():
    a = points()
    moved = a + 0.4 * np.array([1, 0, -2, 3, 0])
    np.testing.assert_allclose(Periodic(0.5, 0.4)(a, moved).diagonal(), 1.0)
    fading = at("locally_periodic", period=0.4)(a, moved).diagonal()
    assert (fading > 0.01).all()
    assert (fading < 0.9).all()


def test_a_rational_quadratic_of_one_length_is_a_squared_exponential():
    a = points()
    np.testing.assert_allclose(RationalQuadratic(0.4, 1e7)(a), SquaredExponential(0.4)(a), atol=1e-6)


@EVERY
def test_the_likelihood_finds_hyperparameters_near_those_that_drew_the_values(name):
    covariance = covariance_of(name)
    a = points(150, 2)
    truth = covariance.theta + 0.3
    drawn = np.random.default_rng(5).multivariate_normal(np.zeros(len(a)), covariance.clone_with_theta(truth)(a), method="cholesky")
    found = likeliest(covariance, a, drawn, None)
    process = GaussianProcessRegressor(covariance, optimizer=None).fit(a, drawn)
    assert process.log_marginal_likelihood(found) > process.log_marginal_likelihood(truth) - 0.5
    assert found[-1] == pytest.approx(truth[-1], abs=0.5), "the noise"
    bounds = covariance.bounds
    assert ((bounds[:, 0] <= found) & (found <= bounds[:, 1])).all()


@EVERY
def test_the_process_predicts_the_signal_and_not_the_noise(name):
    covariance = covariance_of(name)
    a = np.repeat(points(4, 2), 50, axis=0)
    truth = np.repeat([1.0, -1.0, 0.5, 0.0], 50)
    noisy = truth + 0.3 * np.random.default_rng(1).standard_normal(len(a))
    theta = covariance.theta
    theta[-1] = np.log(0.09)
    mean, deviation = condition(covariance, a, noisy, list(theta)).predict(a, return_std=True)
    np.testing.assert_allclose(mean, truth, atol=4 * 0.3 / np.sqrt(50))
    np.testing.assert_allclose(deviation, 0.3 / np.sqrt(50), rtol=0.1)


def test_there_is_a_kernel_for_every_preset_and_a_preset_for_every_kernel():
    assert {settings.family.value for settings in PRESETS.values()} == set(KERNELS)
