"""Gate processes: the miss at each gate as a Gaussian process of the parameters of its own and of earlier segments.

The miss at a gate is log(D / d), D the distance from the gate and d the one that the judge allows, limited to `NEAREST` and `FARTHEST`.
Parameters of later segments cannot change it. The gates of a segment share a Matern 5/2 covariance of the parameters of their segment and
of the segments before it, weighted by powers of `carry`. All gates share the length scales, so that every gate of every flight is data for
them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.tuners.surrogates.gaussian_process import Posterior, fit, log_likelihood, spread_of

Floats = NDArray[np.float64]

NEAREST, FARTHEST = float(np.log(0.25)), float(np.log(3.0))  # limits of a miss, log(D / d)
UNKNOWN = (0.5, 1.0, 0.5)  # mean, standard deviation and noise of the gates of a segment that was reached fewer than twice
LEAST_SPREAD = 0.05  # standard deviation of a gate's values
LEAST_NOISE = 1e-3  # variance, over that of the signal
LEAST_VARIANCE = 1e-4  # of the signal, over that of the values
CENTRE = (np.log(3.0), 0.0, np.log(0.15))  # of the prior: logarithm of a length, logit of `carry`, logarithm of `noise`
SPREAD = (1.0, 1.5, 1.0)
STRIDES = (0.5, 0.7, 0.5)  # standard deviations of a step of the random search, likewise; of every other step `SHORT` times these
SHORT = 0.3
TOGETHER, SINGLE = 0.4, 0.6  # probability that a step changes all lengths alike, and that it changes a given number
ROWS = 100  # latest flights that enter the likelihood


@dataclass(frozen=True)
class GateKernel:
    """Hyperparameters of the covariance of all gates, transformed so that they have no bounds.

    Attributes:
        numbers: shape (K + 2,): logarithms of the length scales; logit of `carry`, the weight of a segment's parameters at the gates of the
            next one; logarithm of the variance of the noise over that of the signal.
    """

    numbers: Floats

    @staticmethod
    def prior(size: int) -> GateKernel:
        """The mode of the prior, for `size` parameters."""
        return GateKernel(np.array([CENTRE[0]] * size + list(CENTRE[1:])))

    @property
    def noise(self) -> float:
        """Variance of the noise over that of the signal."""
        return LEAST_NOISE + float(np.exp(self.numbers[-1]))

    def features(self, points: Floats, segment: int | None) -> Floats:
        """Points of shape (n, S, K) in units of the length scales, weighted for the gates of a segment, shape (n, d).

        The squares of the weights sum to one, so that a change that is the same in all segments is the same distance for every gate.
        Without a segment all weights are equal.
        """
        carry, until = 1 / (1 + np.exp(-self.numbers[-2])), points.shape[1] - 1 if segment is None else segment
        weights = np.ones(until + 1) if segment is None else carry ** np.arange(until, -1, -1.0)
        weights /= np.linalg.norm(weights)
        scaled = points[:, : until + 1] * (weights[:, None] / np.exp(self.numbers[:-2]))
        return scaled.reshape(len(points), -1)


@dataclass(frozen=True)
class Group:
    """Values that depend on the same parameters: the misses at the gates of a segment.

    Attributes:
        segment: index of the segment; None: the values depend on all segments alike.
        columns: indices of the gates.
        rows: indices of the flights in which the miss at any of these gates was measured.
        values: shape (rows, columns); `FARTHEST` where a miss was not measured.
    """

    segment: int | None
    columns: NDArray[np.intp]
    rows: NDArray[np.intp]
    values: Floats


@dataclass(frozen=True)
class Known:
    """A group and its process after the flights: a column of values for each gate."""

    group: Group
    process: Posterior


@dataclass(frozen=True)
class GatePosterior:
    """The processes of M gates after the flights.

    Attributes:
        kernel: of all gates.
        known: the groups with at least two flights.
        size: M.
    """

    kernel: GateKernel
    known: tuple[Known, ...]
    size: int

    def predict(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """Mean and standard deviation of the signal, each of shape (m, M), and of the noise, shape (M,), at points of shape (m, S, K)."""
        means, deviations = (np.full((len(points), self.size), value) for value in UNKNOWN[:2])
        noises = np.full(self.size, UNKNOWN[2])
        for one in self.known:
            columns = one.group.columns
            features = self.kernel.features(points, one.group.segment)
            means[:, columns], deviations[:, columns] = one.process.predict(features)
            noises[columns] = one.process.scale * np.sqrt(self.kernel.noise)
        return means, deviations, noises


def gate_groups(misses: Floats, segments: NDArray[np.int64]) -> list[Group]:
    """The gates of each segment.

    Args:
        misses: shape (n, M), log of distance over the judge's; NaN where a flight did not get to a gate.
        segments: shape (M,), of each gate.
    """
    known = np.isfinite(misses)
    values = np.where(known, np.clip(np.nan_to_num(misses), NEAREST, FARTHEST), FARTHEST)
    groups = []
    for segment in np.unique(segments).tolist():
        columns = np.flatnonzero(segments == segment)
        rows = np.flatnonzero(known[:, columns].any(axis=1))
        groups.append(Group(segment, columns, rows, values[np.ix_(rows, columns)]))
    return groups


def condition(points: Floats, groups: list[Group], kernel: GateKernel) -> GatePosterior:
    """The processes of all gates given the misses of flights at points, shape (n, S, K)."""
    known = []
    for group in groups:
        if len(group.rows) < 2:
            continue
        features = kernel.features(points[group.rows], group.segment)
        process = fit(features, group.values, kernel.noise, least_spread=LEAST_SPREAD, least_variance=LEAST_VARIANCE)
        known.append(Known(group, process.in_single_precision()))
    return GatePosterior(kernel, tuple(known), sum(len(group.columns) for group in groups))


def climb_at_random(points: Floats, groups: list[Group], start: GateKernel, strides: int, rng: np.random.Generator) -> GateKernel:
    """A kernel of higher posterior density, by a random search: a step is taken where the density rises.

    Not an ascent along the gradient, because the published results of gate_gp were measured with this search and stay reproducible.

    Args:
        points: shape (n, S, K), logarithms of the parameters in units of `log_step`.
        groups: the misses measured there.
        start: the kernel that the search begins at.
        strides: number of steps that are tried.
        rng: random generator.
    """
    latest = [_latest(group, len(points)) for group in groups]
    size = len(start.numbers)
    lengths = size - len(CENTRE) + 1
    widths = np.array([STRIDES[0]] * lengths + list(STRIDES[1:]))
    best, highest = start, log_posterior(points, latest, start)
    for _ in range(strides):
        stride = widths * rng.standard_normal(size) * (1.0 if rng.random() < 0.5 else SHORT)
        if rng.random() < TOGETHER:
            stride[:lengths] = stride[0]
        tried = GateKernel(best.numbers + stride * (rng.random(size) < SINGLE))
        height = log_posterior(points, latest, tried)
        if height > highest:
            best, highest = tried, height
    return best


def log_posterior(points: Floats, groups: list[Group], kernel: GateKernel) -> float:
    """Logarithm of a kernel's posterior density, without constants: marginal likelihood of all misses, times the prior of `numbers`.

    Args:
        points: shape (n, S, K).
        groups: the misses measured there.
        kernel: whose density is asked for.
    """
    size = len(kernel.numbers) - len(CENTRE) + 1
    centre, spread = (np.array([three[0]] * size + list(three[1:])) for three in (CENTRE, SPREAD))
    total = -0.5 * float((((kernel.numbers - centre) / spread) ** 2).sum())
    for group in groups:
        if len(group.rows) < 3:
            continue
        centred = (group.values - group.values.mean(axis=0)) / spread_of(group.values, LEAST_SPREAD)
        total += log_likelihood(kernel.features(points[group.rows], group.segment), centred, kernel.noise)
    return total


def _latest(group: Group, count: int) -> Group:
    """A group without the flights before the latest `ROWS`."""
    kept = group.rows >= count - ROWS
    return Group(group.segment, group.columns, group.rows[kept], group.values[kept])
