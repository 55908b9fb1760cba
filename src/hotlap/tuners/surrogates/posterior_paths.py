"""Posterior paths: functions drawn from the posterior of a Gaussian process, for Thompson sampling."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hotlap.tuners.surrogates.gaussian_process import Posterior

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

FEATURES = 1024  # random Fourier features of a path of the prior
SLICE = 128  # points that are evaluated together, so that their features fit into the cache


@dataclass(frozen=True)
class Paths:
    """Functions drawn from a posterior by Matheron's rule: paths of the prior, corrected by the data.

    f(x) = phi(x)' w + k(x, X) (K + noise)^-1 (y - phi(X)' w - e) (Wilson and others, ICML 2020, Eq. 13), phi of random Fourier features
    (Rahimi, Recht, NIPS 2007). The features are computed in single precision, whose error is small beside that of their finite number.

    Attributes:
        posterior: the process given the data.
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

    def prior_at(self, features: Floats | Singles) -> Floats:
        """Values of the paths of the prior, without the mean, shape (m, count), at points in units of the lengths, shape (m, d)."""
        cosines = np.cos(features.astype(np.float32) @ self.frequencies + self.phases)
        return np.asarray(cosines @ self.prior, dtype=np.float64)

    def _at(self, points: Floats) -> Floats:
        known = self.posterior
        return known.mean + self.prior_at(points / known.lengths) + known.across(points) @ self.correction


def draw_paths(posterior: Posterior, noise: float, count: int, rng: np.random.Generator) -> Paths:
    """Independent paths of the signal, without noise.

    Args:
        posterior: a process with this noise.
        noise: variance of the noise over that of the signal.
        count: number of paths.
        rng: random generator.
    """
    number, size = posterior.features.shape
    spread = np.sqrt(rng.chisquare(5, FEATURES) / 5)  # the spectrum of Matern 5/2 is Student's t
    frequencies = (rng.standard_normal((size, FEATURES)) / spread).astype(np.float32)
    phases = (rng.uniform(0, 2 * np.pi, FEATURES)).astype(np.float32)
    prior = (posterior.scale * np.sqrt(2 / FEATURES) * rng.standard_normal((FEATURES, count))).astype(np.float32)
    free = Paths(posterior, frequencies, phases, prior, np.zeros((number, count)))
    errors = posterior.scale * np.sqrt(noise) * rng.standard_normal((number, count))
    surplus = free.prior_at(posterior.features) + errors
    return replace(free, correction=posterior.weights[:, None] - posterior.whitening @ (posterior.whitening.T @ surplus))
