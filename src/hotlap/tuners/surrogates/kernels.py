"""Covariance functions of the paper's baseline BO (Table I), for regression with scikit-learn, in any number of axes.

Distances are r^2 = sum_j (a_j - b_j)^2 / (d length^2) over d axes, so that the same range of length scales serves any number of segments.
The formulas are those of Rasmussen, Williams, "Gaussian processes for machine learning", 2006 (RW). The periodic covariance is the
product of its one-dimensional form over the axes; scikit-learn's is a function of the sine of the Euclidean distance, which is positive
definite in one dimension only. Importing this file loads scikit-learn.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import (
    ConstantKernel,
    Hyperparameter,
    Kernel,
    NormalizedKernelMixin,
    StationaryKernelMixin,
    WhiteKernel,
)

from hotlap.tuners.surrogates.gaussian_process import matern, square_distances

Floats = NDArray[np.float64]

LENGTHS = (0.05, 10.0)  # range of the length scale; random points of the unit box are about 0.4 apart
MIXTURES = (0.05, 100.0)
PERIODS = (0.1, 10.0)
SIGNALS = (0.05, 20.0)  # range of the variance of the signal, of costs whose variance is 1
NOISES = (1e-4, 2.0)  # range of the variance of the noise, likewise
STARTS = 2  # random starts of the ascent of the likelihood, besides the last hyperparameters
ASCENT = 15  # iterations of each ascent


class _Stationary(StationaryKernelMixin, NormalizedKernelMixin, Kernel):  # pyright: ignore[reportIncompatibleMethodOverride]
    """A stationary covariance, 1 at distance 0. Hyperparameters and derivatives along their logarithms are in alphabetical order."""

    def __init__(self, length: float = 0.5) -> None:
        self.length = length

    @property
    def hyperparameter_length(self) -> Hyperparameter:
        """Length scale, in units of sqrt(d) of the unit box."""
        return Hyperparameter("length", "numeric", LENGTHS)

    def __call__(self, X: Floats, Y: Floats | None = None, eval_gradient: bool = False) -> Any:
        """Covariance matrix, shape (n, m), of points of shape (n, d) and (m, d); also its derivatives, shape (n, n, hyperparameters)."""
        a, b = np.atleast_2d(X), np.atleast_2d(X if Y is None else Y)
        gram = self._gram(a, b)
        return (gram, np.stack(self._slopes(a, gram), axis=-1)) if eval_gradient else gram

    @abstractmethod
    def _gram(self, a: Floats, b: Floats) -> Floats:
        """Covariance matrix, shape (n, m)."""

    @abstractmethod
    def _slopes(self, a: Floats, gram: Floats) -> list[Floats]:
        """For each hyperparameter the derivative along its logarithm, shape (n, n)."""

    def _square(self, a: Floats, b: Floats) -> Floats:
        """r^2, shape (n, m)."""
        return square_distances(a, b) / (a.shape[1] * self.length**2)


class Matern(_Stationary):
    """(1 + s + s^2 / 3) exp(-s), s = sqrt(5) r: smoothness 5/2, RW Eq. 4.17."""

    def _gram(self, a: Floats, b: Floats) -> Floats:
        return np.asarray(matern(np.sqrt(5 * self._square(a, b))), dtype=np.float64)

    def _slopes(self, a: Floats, gram: Floats) -> list[Floats]:  # noqa: ARG002
        s = np.sqrt(5 * self._square(a, a))
        return [s**2 / 3 * (1 + s) * np.exp(-s)]


class SquaredExponential(_Stationary):
    """exp(-r^2 / 2), RW Eq. 4.9."""

    def _gram(self, a: Floats, b: Floats) -> Floats:
        return np.exp(-0.5 * self._square(a, b))

    def _slopes(self, a: Floats, gram: Floats) -> list[Floats]:
        return [self._square(a, a) * gram]


class RationalQuadratic(_Stationary):
    """(1 + r^2 / (2 mixture))^-mixture, RW Eq. 4.19: a mixture of squared exponentials; alpha there is `mixture` here."""

    def __init__(self, length: float = 0.5, mixture: float = 1.0) -> None:
        super().__init__(length)
        self.mixture = mixture

    @property
    def hyperparameter_mixture(self) -> Hyperparameter:
        """The larger, the narrower the distribution of the length scales."""
        return Hyperparameter("mixture", "numeric", MIXTURES)

    def _gram(self, a: Floats, b: Floats) -> Floats:
        return (1 + self._square(a, b) / (2 * self.mixture)) ** -self.mixture

    def _slopes(self, a: Floats, gram: Floats) -> list[Floats]:
        square = self._square(a, a)
        base = 1 + square / (2 * self.mixture)
        return [square * gram / base, gram * (square / (2 * base) - self.mixture * np.log(base))]


class Periodic(_Stationary):
    """Product over the axes of exp(-2 sin^2(pi (a_j - b_j) / period) / (d length^2)): RW Eq. 4.31 on every axis."""

    def __init__(self, length: float = 0.5, period: float = 1.0) -> None:
        super().__init__(length)
        self.period = period

    @property
    def hyperparameter_period(self) -> Hyperparameter:
        """Period, in widths of the unit box, the same for all axes."""
        return Hyperparameter("period", "numeric", PERIODS)

    def _gram(self, a: Floats, b: Floats) -> Floats:
        return np.exp(-2 * self._sines(a, b) / self.length**2)

    def _slopes(self, a: Floats, gram: Floats) -> list[Floats]:
        scale = gram / self.length**2
        return [4 * scale * self._sines(a, a), 2 * scale * self._turning(a)]

    def _sines(self, a: Floats, b: Floats) -> Floats:
        """Mean over the axes of sin^2(pi (a_j - b_j) / period), from sin^2 x = (1 - cos 2x) / 2 and the theorem of addition."""
        cosines = (_circle(a, self.period) @ _circle(b, self.period).T) / a.shape[1]
        return np.maximum(0.5 * (1 - cosines), 0.0)

    def _turning(self, a: Floats) -> Floats:
        """Mean over the axes of x_j sin(2 x_j), x_j = pi (a_i - a_k)_j / period: minus the derivative of `_sines` along log period."""
        phase = 2 * np.pi * a / self.period
        sine, cosine = np.sin(phase), np.cos(phase)
        half = (phase * sine) @ cosine.T - (phase * cosine) @ sine.T
        return 0.5 * (half + half.T) / a.shape[1]


def locally_periodic() -> Any:
    """Periodic times squared exponential: a pattern that changes slowly (RW Sec. 5.4.3; Duvenaud, thesis, 2014, Sec. 2.2)."""
    return Periodic() * SquaredExponential(1.0)


KERNELS: Mapping[str, Callable[[], Any]] = {
    "matern": Matern,
    "locally_periodic": locally_periodic,
    "rational_quadratic": RationalQuadratic,
    "squared_exponential": SquaredExponential,
    "periodic": Periodic,
}


def covariance_of(kernel: str) -> Any:
    """Covariance of noisy costs whose variance is 1: variance of the signal times one of `KERNELS`, plus independent noise."""
    return ConstantKernel(1.0, SIGNALS) * KERNELS[kernel]() + WhiteKernel(0.1, NOISES)


def likeliest(covariance: Any, points: Floats, values: Floats, known: list[float] | None) -> list[float]:
    """Logarithms of the hyperparameters of largest marginal likelihood, by L-BFGS-B from several starts (RW Eq. 5.8 and 5.9).

    Args:
        covariance: result of `covariance_of`.
        points: shape (n, d), in the unit box.
        values: shape (n,), standardised.
        known: start of the first ascent; None: the hyperparameters of `covariance`.
    """
    process = _regress(covariance, points, values, 0.0)

    def loss(theta: Floats) -> tuple[float, Floats]:
        likelihood, slope = process.log_marginal_likelihood(theta, eval_gradient=True, clone_kernel=False)
        return -likelihood, -slope

    bounds = covariance.bounds
    drawn = np.random.default_rng(0).uniform(bounds[:, 0], bounds[:, 1], (STARTS, len(bounds)))  # the same at every refit
    starts = [covariance.theta if known is None else np.array(known), *drawn]
    found = [minimize(loss, start, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": ASCENT}) for start in starts]
    return min(found, key=lambda end: end.fun).x.tolist()


def condition(covariance: Any, points: Floats, values: Floats, theta: list[float]) -> Any:
    """The process given values, shape (n,), at points, shape (n, d); it predicts the signal without noise."""
    fitted = covariance.clone_with_theta(np.array(theta))
    return _regress(fitted.k1, points, values, fitted.k2.noise_level)


def _regress(covariance: Any, points: Floats, values: Floats, noise: float) -> Any:
    """Regression without a change of the hyperparameters."""
    return GaussianProcessRegressor(covariance, alpha=noise, optimizer=None).fit(points, values)  # pyright: ignore[reportArgumentType]


def _circle(points: Floats, period: float) -> Floats:
    """Cosines, then sines of the phase 2 pi x / period of every axis, shape (n, 2 d)."""
    phase = 2 * math.pi * points / period
    return np.hstack([np.cos(phase), np.sin(phase)])
