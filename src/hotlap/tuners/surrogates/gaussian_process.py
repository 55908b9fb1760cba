"""Gaussian-process regression of a few hundred noisy values: covariance, Cholesky factor, likelihood with its gradient, prediction.

The covariance is Matern 5/2 of distances in units of the lengths, one for all axes or one for each (automatic relevance determination).
The mean is that of the values and the variance of the signal is that of maximum likelihood, in closed form, unless a `Prior` gives
both. The formulas are
those of Rasmussen, Williams, "Gaussian processes for machine learning", 2006 (RW), and of Jones, Schonlau, Welch, J. Global
Optimization 13, 1998 (JSW).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Reals = NDArray[np.floating[Any]]

LEAST_SPREAD = 1e-9  # least standard deviation of values, by which they are divided
LEAST_VARIANCE = 1e-9  # least variance of the signal, of values whose variance is 1
LEAST_LEFT = {np.dtype(np.float64): 1e-9, np.dtype(np.float32): 1e-6}  # least share of the signal's variance that data leave
CLIMB = 20  # iterations of L-BFGS-B


@dataclass(frozen=True)
class Posterior:
    """A process after n noisy values, or after n rows of c values each, which share a covariance.

    Attributes:
        lengths: scalar or shape (d,), length scales.
        features: shape (n, d), the points in units of the lengths.
        mean: scalar or shape (c,), of the values.
        scale: scalar or shape (c,), standard deviation of the signal in units of the values.
        weights: shape (n,) or (n, c), (K + noise)^-1 (values - mean).
        whitening: shape (n, n) W with W W' = (K + noise)^-1.
    """

    lengths: Floats | float
    features: Reals
    mean: Floats | float
    scale: Floats | float
    weights: Floats
    whitening: Reals

    def predict(self, points: Floats) -> tuple[Floats, Floats]:
        """Mean and standard deviation of the signal, without noise, shape (m,) or (m, c), at points of shape (m, d): RW Eq. 2.25."""
        across = self.across(points)
        reduced = across @ self.whitening
        variance = np.maximum(1.0 - np.einsum("ij,ij->i", reduced, reduced), LEAST_LEFT[reduced.dtype])
        return np.asarray(self.mean + across @ self.weights), np.multiply.outer(np.sqrt(variance), self.scale)

    def covariance(self, a: Floats, b: Floats) -> Reals:
        """Posterior covariance of the signal, without noise, shape (m, k), at points of shape (m, d) and (k, d): RW Eq. 2.24."""
        prior = covariance(a / self.lengths, b / self.lengths)
        return self.scale**2 * (prior - (self.across(a) @ self.whitening) @ (self.across(b) @ self.whitening).T)

    def across(self, points: Floats) -> Reals:
        """Prior covariance of points, shape (m, d), with the n known ones, shape (m, n); 1 at distance 0."""
        return covariance((points / self.lengths).astype(self.features.dtype, copy=False), self.features)

    def in_single_precision(self) -> Posterior:
        """The same process in single precision, four times as fast; standard deviations are at least 1e-3 of the signal's."""
        return replace(self, features=self.features.astype(np.float32), whitening=self.whitening.astype(np.float32))


@dataclass(frozen=True)
class Kernel:
    """Matern 5/2 and independent noise.

    Attributes:
        lengths: scalar or shape (d,), length scale of all axes or of each.
        noise: variance of the noise over that of the signal.
    """

    lengths: Floats | float
    noise: float

    def condition(self, points: Floats, values: Floats) -> Posterior:
        """The process given values, shape (n,), at points, shape (n, d), with the variance of the signal that maximises the likelihood."""
        return fit(points / self.lengths, values, self.noise, lengths=self.lengths)


@dataclass(frozen=True)
class Prior:
    """A process given before there are data.

    Attributes:
        length: length scale of all axes.
        signal: standard deviation of the signal.
        noise: standard deviation of the noise.
    """

    length: float
    signal: float
    noise: float

    def condition(self, points: Floats, values: Floats, mean: float) -> Posterior:
        """The process of a mean given values, shape (n,), at points, shape (n, d): RW Eq. 2.23 and 2.24."""
        features = points / self.length
        whitening = _whitening(features, (self.noise / self.signal) ** 2)
        weights = whitening @ (whitening.T @ (values - mean))
        return Posterior(self.length, features, mean, self.signal, weights, whitening)


def matern(distance: Reals) -> Reals:
    """Matern 5/2 covariance (1 + r + r^2 / 3) exp(-r), RW Eq. 4.17, of r = sqrt(5) times the distance in lengths, any shape."""
    return (1 + distance + distance * distance / 3) * np.exp(-distance)


def square_distances(a: Reals, b: Reals) -> Reals:
    """|a - b|^2, never negative, shape (m, n), of points of shape (m, d) and (n, d), in the precision of these."""
    square = np.einsum("ij,ij->i", a, a)[:, None] + np.einsum("ij,ij->i", b, b) - 2 * (a @ b.T)
    return np.maximum(square, 0)


def covariance(a: Reals, b: Reals) -> Reals:
    """Matern 5/2 of points in units of the lengths, shape (m, n), of points of shape (m, d) and (n, d), in the precision of these."""
    return matern(np.sqrt(5 * square_distances(a, b)))


def cholesky(gram: Reals, noise: float) -> Floats:
    """L with L L' = K + noise, shape (n, n), of a covariance K of signal 1."""
    return np.asarray(np.linalg.cholesky(gram + noise * np.eye(len(gram))), dtype=np.float64)


def fit(
    features: Floats,
    values: Floats,
    noise: float,
    *,
    lengths: Floats | float = 1.0,
    least_spread: float = LEAST_SPREAD,
    least_variance: float = LEAST_VARIANCE,
) -> Posterior:
    """The process given values, with their mean and the variance of the signal that maximises the likelihood (JSW Eq. 5 and 6).

    Args:
        features: shape (n, d), points in units of the lengths.
        values: shape (n,) or (n, c).
        noise: variance of the noise over that of the signal.
        lengths: length scales, by which points are divided in predictions.
        least_spread: lower limit of the standard deviation of the values.
        least_variance: lower limit of the variance of the signal over that of the values.
    """
    mean, spread = values.mean(axis=0), spread_of(values, least_spread)
    whitening = _whitening(features, noise)
    rotated = whitening.T @ ((values - mean) / spread)
    scale = np.sqrt(np.maximum((rotated**2).mean(axis=0), least_variance))
    return Posterior(lengths, features, mean, spread * scale, (whitening @ rotated) * spread, whitening)


def spread_of(values: Floats, least: float = LEAST_SPREAD) -> Floats:
    """Standard deviation of each column, shape (c,), or of all values, a scalar; at least `least`."""
    return np.maximum(values.std(axis=0), least)


def log_likelihood(features: Floats, values: Floats, noise: float) -> float:
    """Logarithm of the marginal likelihood, at its maximum over the signal's variance s^2, summed over columns, without constants.

    log p = -n/2 log s^2 - 1/2 log|K + noise|, s^2 = y' (K + noise)^-1 y / n (JSW Eq. 4 and 6, with noise);
    n/2 (log 2 pi + 1) for each column is left out.

    Args:
        features: shape (n, d), points in units of the lengths.
        values: shape (n,) or (n, c), of mean 0.
        noise: variance of the noise over that of the signal.
    """
    factor = cholesky(covariance(features, features), noise)
    return _height(factor, np.linalg.solve(factor, values))


def log_likelihood_with_gradient(points: Floats, values: Floats, logarithms: Floats) -> tuple[float, Floats]:
    """`log_likelihood` and its gradient along the logarithms of the lengths and of the noise.

    d log p = -1/2 tr((A - a a' / s^2) dK), A = (K + noise)^-1, a = A y, summed over columns (RW Eq. 5.9; ds adds nothing at the best s).

    Args:
        points: shape (n, d).
        values: shape (n,) or (n, c), of mean 0.
        logarithms: shape (d + 1,), of the lengths and of the noise.

    Returns:
        The likelihood, and its gradient, shape (d + 1,).
    """
    scaled, noise = points / np.exp(logarithms[:-1]), float(np.exp(logarithms[-1]))
    columns = values.reshape(len(points), -1)
    r = np.sqrt(5 * square_distances(scaled, scaled))
    factor = cholesky(matern(r), noise)
    whitening = np.linalg.inv(factor)
    rotated = whitening @ columns
    weights, inverse = whitening.T @ rotated, whitening.T @ whitening
    pull = columns.shape[1] * inverse - (weights / _variance(rotated)) @ weights.T
    bend = pull * (5 / 3) * (1 + r) * np.exp(-r)  # dK / d log l_k = 5/3 (1 + r) exp(-r) (x_k - x'_k)^2 / l_k^2
    slope = (scaled * (bend @ scaled)).sum(axis=0) - bend.sum(axis=1) @ scaled**2
    return _height(factor, rotated), np.append(slope, -0.5 * noise * np.trace(pull))


def climb(points: Floats, values: Floats, start: Kernel, lengths: tuple[float, float], noises: tuple[float, float]) -> Kernel:
    """The kernel, a length for each axis, that L-BFGS-B finds on the marginal likelihood with its gradient.

    Args:
        points: shape (n, d).
        values: shape (n,).
        start: where the ascent begins, moved within the bounds.
        lengths: least and largest length.
        noises: least and largest noise.
    """
    from scipy.optimize import minimize  # noqa: PLC0415  a tenth of a second

    bounds = np.log([lengths] * points.shape[1] + [noises])
    first = np.log(np.append(np.broadcast_to(start.lengths, points.shape[1]), start.noise))
    centred = (values - values.mean()) / spread_of(values)

    def loss(logarithms: Floats) -> tuple[float, Floats]:
        likelihood, slope = log_likelihood_with_gradient(points, centred, logarithms)
        return -likelihood, -slope

    first = np.clip(first, bounds[:, 0], bounds[:, 1])
    found = np.exp(minimize(loss, first, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": CLIMB}).x)
    return Kernel(found[:-1], float(found[-1]))


def likeliest_of(points: Floats, values: Floats, lengths: Iterable[float], noises: Iterable[float]) -> Kernel:
    """The kernel of largest marginal likelihood on a grid, one length for all axes.

    Args:
        points: shape (n, d).
        values: shape (n,).
        lengths: of the grid.
        noises: of the grid.
    """
    centred = (values - values.mean()) / spread_of(values)
    grid = [Kernel(length, noise) for length, noise in product(lengths, noises)]
    return max(grid, key=lambda kernel: log_likelihood(points / kernel.lengths, centred, kernel.noise))


def _whitening(features: Floats, noise: float) -> Floats:
    """W with W W' = (K + noise)^-1, shape (n, n)."""
    return np.asarray(np.linalg.inv(cholesky(covariance(features, features), noise)), dtype=np.float64).T


def _variance(rotated: Reals) -> Reals:
    """s^2 of each column of L^-1 y, shape (c,), or a scalar."""
    return np.maximum((rotated**2).mean(axis=0), LEAST_VARIANCE)


def _height(factor: Floats, rotated: Reals) -> float:
    """The likelihood, given L and L^-1 y."""
    return -float((0.5 * len(factor) * np.log(_variance(rotated)) + np.log(np.diag(factor)).sum()).sum())
