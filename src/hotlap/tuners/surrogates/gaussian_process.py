"""Gaussian-process regression for tuners: few hundred noisy costs, many dimensions, milliseconds.

Matern 5/2 kernel, one length for all axes, constant mean (Rasmussen, Williams, "Gaussian processes for machine learning", 2006,
Eq. 4.17). Length and noise are picked from small grids by marginal likelihood (their Eq. 5.8), the signal's variance in closed form:
one eigendecomposition for each length serves all noises. Where bounds must be trusted before there are data, a `Prior` is stated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LENGTHS = (0.7, 1.5, 3.0, 6.0)  # times the square root of the number of segments
NOISES = (0.02, 0.1, 0.3, 0.8)  # variance of the noise over that of the signal


@dataclass(frozen=True)
class Shape:
    """Length of the kernel, and variance of the noise over that of the signal."""

    length: float
    noise: float


@dataclass(frozen=True)
class Posterior:
    """What is known after some points.

    Attributes:
        points: shape (n, d).
        length: of the kernel.
        mean: of all values.
        scale: standard deviation of the signal, in units of the values.
        weights: shape (n,).
        whitening: shape (n, n) W with W W' the inverse of the kernel matrix.
    """

    points: Floats
    length: float
    mean: float
    scale: float
    weights: Floats
    whitening: Floats

    def predict(self, points: Floats) -> tuple[Floats, Floats]:
        """Mean and standard deviation of the signal, without noise, each of shape (m,), at points of shape (m, d)."""
        across = matern(points, self.points, self.length)
        reduced = across @ self.whitening
        variance = np.maximum(1.0 - np.einsum("ij,ij->i", reduced, reduced), 1e-9)
        return self.mean + across @ self.weights, self.scale * np.sqrt(variance)


@dataclass(frozen=True)
class Prior:
    """A process that is stated beforehand: length of the kernel, standard deviations of the signal and of the noise."""

    length: float
    signal: float
    noise: float

    def covariance(self, a: Floats, b: Floats) -> Floats:
        """Of the signal, shape (m, n), at points of shape (m, d) and (n, d)."""
        return self.signal**2 * matern(a, b, self.length)


@dataclass(frozen=True)
class Conditioned:
    """A stated process after some points (Rasmussen, Williams, 2006, Eq. 2.23 and 2.24).

    Attributes:
        points: shape (n, d).
        prior: the process.
        mean: of the prior.
        whitening: shape (n, n) W, the inverse of L with L L' the covariance of the noisy values.
        residuals: shape (n,), W (values - mean).
    """

    points: Floats
    prior: Prior
    mean: float
    whitening: Floats
    residuals: Floats

    def predict(self, points: Floats) -> tuple[Floats, Floats]:
        """Mean and standard deviation of the signal, without noise, each of shape (m,), at points of shape (m, d)."""
        reduced = self._reduce(points)
        variance = self.prior.signal**2 - (reduced**2).sum(axis=0)
        return self.mean + self.residuals @ reduced, np.sqrt(np.maximum(variance, 1e-9 * self.prior.signal**2))

    def covariance(self, a: Floats, b: Floats) -> Floats:
        """Of the signal, without noise, shape (m, n), at points of shape (m, d) and (n, d)."""
        return self.prior.covariance(a, b) - self._reduce(a).T @ self._reduce(b)

    def _reduce(self, points: Floats) -> Floats:
        """W k(points), shape (n, m)."""
        return self.whitening @ self.prior.covariance(self.points, points)


def condition(points: Floats, values: Floats, mean: float, prior: Prior) -> Conditioned:
    """Condition a stated process, with a mean, on noisy values, shape (n,), at points, shape (n, d)."""
    factor = np.linalg.cholesky(prior.covariance(points, points) + prior.noise**2 * np.eye(len(points)))
    whitening = np.asarray(np.linalg.inv(factor), dtype=np.float64)
    return Conditioned(points, prior, mean, whitening, whitening @ (values - mean))


def matern(a: Floats, b: Floats, length: float) -> Floats:
    """(1 + r + r^2 / 3) exp(-r), r = sqrt(5) |a - b| / length, shape (m, n)."""
    square = np.maximum((a**2).sum(1)[:, None] + (b**2).sum(1)[None] - 2 * a @ b.T, 0.0)
    r = np.sqrt(5 * square) / length
    return (1 + r + r**2 / 3) * np.exp(-r)


def fit(points: Floats, values: Floats, shape: Shape) -> Posterior:
    """Condition on values, shape (n,), at points, shape (n, d)."""
    eigenvalues, vectors = _decompose(points, shape.length)
    mean, spread = _standard(values)
    rotated = vectors.T @ ((values - mean) / spread)
    regular = eigenvalues + shape.noise
    scale = float(np.sqrt(max(np.mean(rotated**2 / regular), 1e-12)))
    weights = spread * (vectors @ (rotated / regular))
    return Posterior(points, shape.length, mean, spread * scale, weights, vectors / np.sqrt(regular))


def choose_shape(points: Floats, values: Floats, lengths: tuple[float, ...]) -> Shape:
    """The most likely shape among some lengths and `NOISES`."""
    mean, spread = _standard(values)
    best, shape = -np.inf, Shape(lengths[0], NOISES[0])
    for length in lengths:
        eigenvalues, vectors = _decompose(points, length)
        rotated = (vectors.T @ ((values - mean) / spread)) ** 2
        for noise in NOISES:
            regular = eigenvalues + noise
            likelihood = -0.5 * len(values) * np.log(max(np.mean(rotated / regular), 1e-12)) - 0.5 * np.log(regular).sum()
            if likelihood > best:
                best, shape = likelihood, Shape(length, noise)
    return shape


def _decompose(points: Floats, length: float) -> tuple[Floats, Floats]:
    """Eigenvalues, never negative, and eigenvectors of the kernel matrix."""
    eigenvalues, vectors = np.linalg.eigh(matern(points, points, length))
    return np.maximum(eigenvalues, 0.0), vectors


def _standard(values: Floats) -> tuple[float, float]:
    """Mean and standard deviation, at least 1e-9."""
    return float(values.mean()), max(float(values.std()), 1e-9)
