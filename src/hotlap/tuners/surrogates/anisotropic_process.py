"""Gaussian process with a length for each axis (automatic relevance determination), and functions drawn from a posterior.

Points divided by the lengths have a kernel of length 1, so `gaussian_process.fit` serves here too. The likelihood is climbed by
L-BFGS-B with its gradient.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hotlap.tuners.surrogates.gaussian_process import Posterior, Shape, fit, matern

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

LENGTHS = (0.005, 2.0)  # bounds in a unit box, and of the noise: released code of TuRBO
NOISES = (5e-4, 0.2)
CLIMB = 20  # iterations
TINY = 1e-12  # least variance of the signal
FEATURES = 1024  # cosines that a path of the prior is made of
SLICE = 128  # points whose cosines fit into a cache


@dataclass(frozen=True)
class Kernel:
    """Lengths, shape (d,), and variance of the noise over that of the signal."""

    lengths: Floats
    noise: float

    def condition(self, points: Floats, values: Floats) -> Posterior:
        """Condition on values, shape (n,), at points, shape (n, d); the posterior takes points divided by the lengths."""
        return fit(points / self.lengths, values, Shape(1.0, self.noise))


@dataclass(frozen=True)
class Paths:
    """Functions drawn from a posterior by Matheron's rule: paths of the prior, corrected by what the data say.

    f(x) = phi(x)' w + k(x, X) (K + noise)^-1 (y - phi(X)' w - e) (Wilson and others, ICML 2020, Eq. 13), phi of random Fourier features
    (Rahimi, Recht, NIPS 2007). Single precision will do for a path of the prior: rounded, it is a path still.

    Attributes:
        posterior: what is known.
        frequencies: shape (d, `FEATURES`).
        phases: shape (`FEATURES`,).
        prior: weights w of the features, shape (`FEATURES`, count).
        correction: weights of the kernel, shape (n, count).
    """

    posterior: Posterior
    frequencies: Singles
    phases: Singles
    prior: Singles
    correction: Floats

    def at(self, points: Floats) -> Floats:
        """Values of all paths, shape (m, count), at points, shape (m, d)."""
        return np.concatenate([self._at(points[i : i + SLICE]) for i in range(0, len(points), SLICE)])

    def prior_at(self, points: Floats) -> Floats:
        """Values of the paths of the prior, without the mean, shape (m, count)."""
        features = np.cos(points.astype(np.float32) @ self.frequencies + self.phases)
        return np.asarray(features @ self.prior, dtype=np.float64)

    def _at(self, points: Floats) -> Floats:
        known = self.posterior
        return known.mean + self.prior_at(points) + matern(points, known.points, known.length) @ self.correction


def draw_paths(posterior: Posterior, noise: float, count: int, rng: np.random.Generator) -> Paths:
    """Independent paths of the signal, without noise.

    Args:
        posterior: of a kernel with this noise.
        noise: variance of the noise over that of the signal.
        count: how many.
        rng: the source of chance.
    """
    number, size = posterior.points.shape
    spread = posterior.length * np.sqrt(rng.chisquare(5, FEATURES) / 5)  # the spectrum of Matern 5/2 is Student's t
    frequencies = (rng.standard_normal((size, FEATURES)) / spread).astype(np.float32)
    phases = (rng.uniform(0, 2 * np.pi, FEATURES)).astype(np.float32)
    prior = (posterior.scale * np.sqrt(2 / FEATURES) * rng.standard_normal((FEATURES, count))).astype(np.float32)
    free = Paths(posterior, frequencies, phases, prior, np.zeros((number, count)))
    errors = posterior.scale * np.sqrt(noise) * rng.standard_normal((number, count))
    surplus = free.prior_at(posterior.points) + errors
    return replace(free, correction=posterior.weights[:, None] - posterior.whitening @ (posterior.whitening.T @ surplus))


def most_likely(points: Floats, values: Floats, start: Kernel) -> Kernel:
    """The kernel that the marginal likelihood climbs to from a start.

    Args:
        points: in a unit box, shape (n, d).
        values: shape (n,).
        start: where to begin.
    """
    from scipy.optimize import minimize  # noqa: PLC0415  a tenth of a second

    bounds = np.log([LENGTHS] * points.shape[1] + [NOISES])
    first = np.clip(np.log([*start.lengths, start.noise]), bounds[:, 0], bounds[:, 1])
    centred = (values - values.mean()) / max(float(values.std()), 1e-9)

    def loss(logarithms: Floats) -> tuple[float, Floats]:
        likelihood, slope = log_likelihood(points, centred, logarithms)
        return -likelihood, -slope

    found = np.exp(minimize(loss, first, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": CLIMB}).x)
    return Kernel(found[:-1], float(found[-1]))


def log_likelihood(points: Floats, values: Floats, logarithms: Floats) -> tuple[float, Floats]:
    """Marginal likelihood at the signal's best variance s^2 = y' A y / n, and its gradient.

    log p = -n/2 (log(2 pi s^2) + 1) - 1/2 log|K + noise|, A = (K + noise)^-1 (Jones, Schonlau, Welch, 1998, Eq. 4 and 6, with noise);
    d log p = -1/2 tr((A - a a') dK), a = A y / s (Rasmussen, Williams, 2006, Eq. 5.9; s is at its best, and adds nothing).

    Args:
        points: shape (n, d).
        values: shape (n,), of mean 0.
        logarithms: shape (d + 1,), of the lengths and of the noise.

    Returns:
        The likelihood, and its gradient, shape (d + 1,).
    """
    scaled, noise, count = points / np.exp(logarithms[:-1]), float(np.exp(logarithms[-1])), len(points)
    square = (scaled**2).sum(1)
    r = np.sqrt(5 * np.maximum(square[:, None] + square - 2 * scaled @ scaled.T, 0.0))
    decay = np.exp(-r)
    factor = np.linalg.cholesky((1 + r + r**2 / 3) * decay + noise * np.eye(count))
    half = np.linalg.inv(factor)
    inverse = half.T @ half
    weights = inverse @ values
    variance = max(float(values @ weights) / count, TINY)
    likelihood = -0.5 * count * (np.log(2 * np.pi * variance) + 1) - np.log(np.diag(factor)).sum()
    pull = inverse - np.outer(weights, weights) / variance
    bend = pull * (5 / 3) * (1 + r) * decay  # dK / d log l_k = 5/3 (1 + r) exp(-r) (x_k - x'_k)^2 / l_k^2
    slope = (scaled * (bend @ scaled)).sum(0) - bend.sum(1) @ scaled**2
    return float(likelihood), np.append(slope, -0.5 * noise * np.trace(pull))
