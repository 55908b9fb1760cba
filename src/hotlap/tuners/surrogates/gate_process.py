"""Gate processes: how far each gate is missed, as a Gaussian process of the parameters flown until then, not of those flown later.

A flight over M gates says M things, and a later segment cannot change an earlier gate. The gates of a segment share a kernel, Matern 5/2
over the parameters of their segment and, less and less, of those before it; all segments share its lengths, so that these are learned
from every gate of every flight. Values are logarithms of distance over the judge's, within `NEAREST` and `FARTHEST`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Reals = TypeVar("Reals", Floats, Singles)

NEAREST, FARTHEST = float(np.log(0.25)), float(np.log(3.0))  # what a miss counts as at least and at most
UNKNOWN = (0.5, 1.0, 0.5)  # mean, standard deviation and noise of the gates of a segment that was reached fewer than twice
LEAST_SPREAD = 0.05  # standard deviation of a gate's values
LEAST_NOISE = 1e-3  # variance, over that of the signal
LEAST_VARIANCE = 1e-4  # of the signal, over that of the values
CENTRE = (np.log(3.0), 0.0, np.log(0.15))  # of the prior: logarithm of a length, logit of `carry`, logarithm of `noise`
SPREAD = (1.0, 1.5, 1.0)
STRIDES = (0.5, 0.7, 0.5)  # of a climb, likewise; every other one is `SHORT` of it
SHORT = 0.3
TOGETHER, SINGLE = 0.4, 0.6  # share of strides that change all lengths alike, and by which each number is changed
ROWS = 100  # latest flights that the likelihood is asked about


@dataclass(frozen=True)
class GateKernel:
    """The kernel of all gates, as numbers without bounds.

    Attributes:
        numbers: shape (K + 2,): logarithms of the lengths, logit of what a segment carries over to the next, logarithm of the noise's
            variance over the signal's.
    """

    numbers: Floats

    @staticmethod
    def prior(size: int) -> GateKernel:
        """The most likely one before there are data, of `size` parameters."""
        return GateKernel(np.array([CENTRE[0]] * size + list(CENTRE[1:])))

    @property
    def noise(self) -> float:
        """Variance of the noise over that of the signal."""
        return LEAST_NOISE + float(np.exp(self.numbers[-1]))

    def features(self, points: Floats, segment: int | None) -> Floats:
        """Points, shape (n, S, K), as what the gates of a segment depend on: distances are those of the kernel, shape (n, d).

        Parameters that move alike in all segments are as far apart for every gate. Where no segment is named, all count alike.
        """
        carry, until = 1 / (1 + np.exp(-self.numbers[-2])), points.shape[1] - 1 if segment is None else segment
        weights = np.ones(until + 1) if segment is None else carry ** np.arange(until, -1, -1.0)
        weights /= np.linalg.norm(weights)
        scaled = points[:, : until + 1] * (weights[:, None] / np.exp(self.numbers[:-2]))
        return scaled.reshape(len(points), -1)


@dataclass(frozen=True)
class Group:
    """Values that depend on the same parameters: those of a segment's gates.

    Attributes:
        segment: until which parameters matter; None: all matter alike.
        columns: indices of the values.
        rows: indices of the flights in which any of them is known.
        values: shape (rows, columns); what is not known there counts as `FARTHEST`.
    """

    segment: int | None
    columns: NDArray[np.intp]
    rows: NDArray[np.intp]
    values: Floats


@dataclass(frozen=True)
class Known:
    """A group after its flights, of which there are n.

    Attributes:
        group: what is known.
        features: shape (n, d).
        mean: shape (columns,).
        scale: shape (columns,), standard deviation of the signal.
        weights: shape (n, columns).
        whitening: shape (n, n) W with W W' the inverse of the kernel matrix.
    """

    group: Group
    features: Floats
    mean: Floats
    scale: Floats
    weights: Floats
    whitening: Singles


@dataclass(frozen=True)
class GatePosterior:
    """What is known of M values.

    Attributes:
        kernel: of all values.
        known: the groups that have been seen at least twice.
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
            features = self.kernel.features(points, one.group.segment)
            across = matern(features.astype(np.float32), one.features.astype(np.float32))  # four times as fast
            reduced = across @ one.whitening
            variance = np.maximum(1.0 - np.einsum("ij,ij->i", reduced, reduced), 1e-6)
            means[:, one.group.columns] = one.mean + across @ one.weights
            deviations[:, one.group.columns] = np.sqrt(variance)[:, None] * one.scale
            noises[one.group.columns] = one.scale * np.sqrt(self.kernel.noise)
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
    """What is known after flights at points, shape (n, S, K)."""
    known = []
    for group in groups:
        if len(group.rows) < 2:
            continue
        features = kernel.features(points[group.rows], group.segment)
        mean, spread = group.values.mean(axis=0), _spread(group.values)
        whitening = np.linalg.inv(_factor(features, kernel.noise))
        rotated = whitening @ ((group.values - mean) / spread)
        scale = np.sqrt(np.maximum((rotated**2).mean(axis=0), LEAST_VARIANCE))
        weights = (whitening.T @ rotated) * spread
        known.append(Known(group, features, mean, spread * scale, weights, whitening.T.astype(np.float32)))
    return GatePosterior(kernel, tuple(known), sum(len(group.columns) for group in groups))


def climb(points: Floats, groups: list[Group], start: GateKernel, strides: int, rng: np.random.Generator) -> GateKernel:
    """A likelier kernel, found by random strides of which those that lead upwards are taken.

    Args:
        points: shape (n, S, K).
        groups: what was flown there.
        start: where the climb begins.
        strides: how many are tried.
        rng: the source of chance.
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
    """Marginal likelihood of all values at the signal's best variances, times the prior of the shape; without constants.

    Rasmussen, Williams, "Gaussian processes for machine learning", 2006, Eq. 5.8.

    Args:
        points: shape (n, S, K).
        groups: what was flown there.
        kernel: what is asked about.
    """
    size = len(kernel.numbers) - len(CENTRE) + 1
    centre, spread = (np.array([three[0]] * size + list(three[1:])) for three in (CENTRE, SPREAD))
    total = -0.5 * float((((kernel.numbers - centre) / spread) ** 2).sum())
    for group in groups:
        count = len(group.rows)
        if count < 3:
            continue
        factor = _factor(kernel.features(points[group.rows], group.segment), kernel.noise)
        centred = (group.values - group.values.mean(axis=0)) / _spread(group.values)
        variance = np.maximum((np.linalg.solve(factor, centred) ** 2).mean(axis=0), 1e-9)
        total -= float((0.5 * count * np.log(variance) + np.log(np.diag(factor)).sum()).sum())
    return total


def matern(a: Reals, b: Reals) -> Reals:
    """(1 + r + r^2 / 3) exp(-r), r = sqrt(5) |a - b|, shape (m, n), in the precision of its arguments."""
    square = np.einsum("ij,ij->i", a, a)[:, None] + np.einsum("ij,ij->i", b, b) - 2 * (a @ b.T)
    r = np.sqrt(5 * np.maximum(square, 0))
    return (1 + r + r * r / 3) * np.exp(-r)


def _factor(features: Floats, noise: float) -> Floats:
    """L with L L' the kernel matrix of noisy values."""
    return np.asarray(np.linalg.cholesky(matern(features, features) + noise * np.eye(len(features))), dtype=np.float64)


def _spread(values: Floats) -> Floats:
    """Standard deviation of each column, shape (columns,)."""
    return np.maximum(values.std(axis=0), LEAST_SPREAD)


def _latest(group: Group, count: int) -> Group:
    """A group without what was flown more than `ROWS` flights ago."""
    kept = group.rows >= count - ROWS
    return Group(group.segment, group.columns, group.rows[kept], group.values[kept])
