"""Gate ensemble: the gate processes of `gate_process`, computed together and brought up to date flight by flight.

All processes see the same flights, so their matrices have one shape and are computed by one call, not by one for each segment. A
flight that did not reach the gates of a process has no weight in it. A further flight adds a row to the inverse of the Cholesky factor,
which takes n^2 operations, not n^3.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.tuners.surrogates.gate_process import (
    CENTRE,
    FARTHEST,
    LEAST_SPREAD,
    LEAST_VARIANCE,
    NEAREST,
    SHORT,
    SINGLE,
    SPREAD,
    STRIDES,
    TOGETHER,
    UNKNOWN,
    GateKernel,
)
from hotlap.tuners.surrogates.gaussian_process import matern

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Reals = NDArray[np.floating[Any]]

LEAST_LEFT = 1e-6  # least share of the signal's variance that data leave, in single precision
FEW = 2  # flights below which a process knows nothing


@dataclass(frozen=True)
class Processes:
    """Which parameters and which gates belong to each of G processes.

    Attributes:
        segments: of the gates of each process; None: its values depend on all segments alike.
        columns: shape (G, C) indices of the gates of each process; where it has fewer than C, M, which is none.
        size: M, number of gates.
    """

    segments: tuple[int | None, ...]
    columns: NDArray[np.intp]
    size: int

    @staticmethod
    def of_gates(segments: NDArray[np.int64]) -> Processes:
        """A process for the gates of each segment; `segments`, shape (M,), are those of the gates."""
        owners, count = np.unique(segments).tolist(), len(segments)
        own = [np.flatnonzero(segments == owner) for owner in owners]
        columns = np.full((len(own), max(map(len, own))), count)
        for row, gates in zip(columns, own, strict=True):
            row[: len(gates)] = gates
        return Processes(tuple(owners), columns, count)

    @staticmethod
    def of_cost() -> Processes:
        """One process of the cost."""
        return Processes((None,), np.zeros((1, 1), dtype=np.intp), 1)

    def weights(self, kernel: GateKernel, count: int) -> Floats:
        """Weight of each of `count` segments in each process, shape (G, count); the squares of a row sum to one."""
        carry, places = 1 / (1 + np.exp(-kernel.numbers[-2])), np.arange(count)
        rows = [
            np.ones(count) if own is None else np.where(places <= own, carry ** np.maximum(own - places, 0), 0.0) for own in self.segments
        ]
        return np.array(rows) / np.linalg.norm(rows, axis=1, keepdims=True)

    def spread(self, misses: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """The values of each process.

        Args:
            misses: shape (n, M), NaN where a flight did not get to a gate.

        Returns:
            Values, shape (G, n, C), and which flights count in each process, shape (G, n).
        """
        padded = np.pad(misses, ((0, 0), (0, 1)), constant_values=np.nan)[:, self.columns].transpose(1, 0, 2)
        known = np.isfinite(padded)
        return np.where(known, padded, FARTHEST), np.asarray(known.any(axis=2))


class GateEnsemble:
    """The processes of all gates after some flights.

    Args:
        processes: which there are.
        kernel: of all of them.
        points: shape (n, S, K), n at least 1.
        values: shape (G, n, C).
        seen: shape (G, n), whether a flight counts in a process.
    """

    def __init__(self, processes: Processes, kernel: GateKernel, points: Floats, values: Floats, seen: NDArray[np.bool_]) -> None:
        self.processes, self.kernel = processes, kernel
        self._scaling = _scaling(processes, kernel, points.shape[1])
        self._values, self._seen = values, seen
        self._features = _features(points, self._scaling)
        self._single = self._features.astype(np.float32)
        self._whitening = np.linalg.inv(_factor(self._features, kernel.noise, seen)) * seen[:, :, None]
        self._learn()

    def __len__(self) -> int:
        """n, the flights that it knows."""
        return self._seen.shape[1]

    def append(self, points: Floats, values: Floats, seen: NDArray[np.bool_]) -> None:
        """Further flights: points of shape (m, S, K), values of shape (G, m, C), and which count, shape (G, m)."""
        for i in range(len(points)):
            self._add(_features(points[i : i + 1], self._scaling), values[:, i : i + 1], seen[:, i])
        if len(points):
            self._learn()

    def predict(self, points: Floats, *, means_only: bool = False) -> tuple[Floats, Floats, Floats]:
        """Mean and standard deviation of the signal, each of shape (m, M), and of the noise, shape (M,), at points of shape (m, S, K).

        Args:
            points: where.
            means_only: leave the standard deviations 0, which takes a fraction of the time.
        """
        across = _matern_across(_features(points, self._scaling).astype(np.float32), self._single)
        means = (across @ self._pull).astype(np.float64) + self._mean[:, None]
        deviations = np.zeros_like(means)
        if not means_only:
            reduced = across @ self._reducing
            left = np.sqrt(np.maximum(1.0 - np.einsum("gmn,gmn->gm", reduced, reduced), LEAST_LEFT))
            deviations = left[:, :, None] * self._scale[:, None]
        means[~self._known], deviations[~self._known] = UNKNOWN[:2]
        noises = np.where(self._known[:, None], self._scale * np.sqrt(self.kernel.noise), UNKNOWN[2])
        return self._by_gate(means), self._by_gate(deviations), self._by_gate(noises[:, None])[0]

    def _add(self, features: Floats, values: Floats, seen: NDArray[np.bool_]) -> None:
        """A row of the inverse factor: [-(l W) / d, 1 / d], l = W k, d^2 = 1 + noise - l'l."""
        across = matern(np.sqrt(5 * _square_distances(features, self._features)))[:, 0] * self._seen
        solved = np.einsum("gij,gj->gi", self._whitening, across)
        left = np.sqrt(np.maximum(1 + self.kernel.noise - (solved**2).sum(axis=1), self.kernel.noise))
        groups, count = self._seen.shape
        grown = np.zeros((groups, count + 1, count + 1))
        grown[:, :count, :count] = self._whitening
        grown[:, count, :count] = -np.einsum("gi,gij->gj", solved, self._whitening) / left[:, None]
        grown[:, count, count] = 1 / left
        grown[:, count] *= seen[:, None]
        self._whitening = grown
        self._features = np.concatenate([self._features, features], axis=1)
        self._single = np.concatenate([self._single, features.astype(np.float32)], axis=1)
        self._values = np.concatenate([self._values, values], axis=1)
        self._seen = np.concatenate([self._seen, seen[:, None]], axis=1)

    def _learn(self) -> None:
        """Mean, scale and weights of every gate, with the variance of the signal that maximises the likelihood."""
        counts = np.maximum(self._seen.sum(axis=1), 1)[:, None]
        self._known = self._seen.sum(axis=1) >= FEW
        self._mean, spread, standard = _standardise(self._values, self._seen)
        rotated = self._whitening @ standard
        self._scale = spread * np.sqrt(np.maximum((rotated**2).sum(axis=1) / counts, LEAST_VARIANCE))
        self._pull = (self._whitening.transpose(0, 2, 1) @ rotated * spread[:, None]).astype(np.float32)
        self._reducing = self._whitening.transpose(0, 2, 1).astype(np.float32)

    def _by_gate(self, values: Floats) -> Floats:
        """Values of shape (G, m, C) as (m, M)."""
        gates = np.empty((values.shape[1], self.processes.size + 1))
        gates[:, self.processes.columns] = values.transpose(1, 0, 2)
        return gates[:, :-1]


def climb(
    processes: Processes, points: Floats, values: Floats, seen: NDArray[np.bool_], start: GateKernel, strides: int, rng: np.random.Generator
) -> GateKernel:
    """A kernel of higher posterior density, by a random search: a step is taken where the density rises.

    Args:
        processes: which there are.
        points: shape (n, S, K).
        values: shape (G, n, C).
        seen: shape (G, n).
        start: the kernel that the search begins at.
        strides: number of steps that are tried.
        rng: random generator.
    """
    size = len(start.numbers)
    lengths = size - len(CENTRE) + 1
    widths = np.array([STRIDES[0]] * lengths + list(STRIDES[1:]))
    _, _, standard = _standardise(values, seen)
    best, highest = start, log_posterior(processes, points, standard, seen, start)
    for _ in range(strides):
        stride = widths * rng.standard_normal(size) * (1.0 if rng.random() < 0.5 else SHORT)
        if rng.random() < TOGETHER:
            stride[:lengths] = stride[0]
        tried = GateKernel(best.numbers + stride * (rng.random(size) < SINGLE))
        height = log_posterior(processes, points, standard, seen, tried)
        if height > highest:
            best, highest = tried, height
    return best


def log_posterior(processes: Processes, points: Floats, standard: Floats, seen: NDArray[np.bool_], kernel: GateKernel) -> float:
    """Logarithm of a kernel's posterior density, as `gate_process.log_posterior` has it.

    Args:
        processes: which there are.
        points: shape (n, S, K).
        standard: standardised values, shape (G, n, C), 0 where a flight or a gate does not count.
        seen: shape (G, n).
        kernel: whose density is asked for.
    """
    size = len(kernel.numbers) - len(CENTRE) + 1
    centre, spread = (np.array([three[0]] * size + list(three[1:])) for three in (CENTRE, SPREAD))
    prior = -0.5 * float((((kernel.numbers - centre) / spread) ** 2).sum())
    factor = _factor(_features(points, _scaling(processes, kernel, points.shape[1])), kernel.noise, seen)
    rotated, counts = np.linalg.solve(factor, standard), seen.sum(axis=1)[:, None]
    variance = np.maximum((rotated**2).sum(axis=1) / np.maximum(counts, 1), LEAST_VARIANCE)
    heights = 0.5 * counts * np.log(variance) + np.log(np.diagonal(factor, axis1=1, axis2=2)).sum(axis=1)[:, None]
    counted = (processes.columns < processes.size) & (counts > FEW)
    return prior - float(heights[counted].sum())


def values_of(processes: Processes, misses: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Values and seen flights of misses, shape (n, M), log of distance over the judge's; NaN where a flight did not get to a gate."""
    return processes.spread(np.clip(misses, NEAREST, FARTHEST))


def _scaling(processes: Processes, kernel: GateKernel, segments: int) -> Floats:
    """What a point is multiplied by in each process, shape (G, S, K)."""
    return processes.weights(kernel, segments)[:, :, None] / np.exp(kernel.numbers[:-2])


def _features(points: Floats, scaling: Floats) -> Floats:
    """Points of shape (n, S, K) in units of the lengths, weighted for each process, shape (G, n, S K)."""
    return (points * scaling[:, None]).reshape(len(scaling), len(points), -1)


def _square_distances(a: Reals, b: Reals) -> Reals:
    """|a - b|^2, never negative, shape (G, m, n), of features of shape (G, m, d) and (G, n, d)."""
    square = np.einsum("gij,gij->gi", a, a)[:, :, None] + np.einsum("gij,gij->gi", b, b)[:, None] - 2 * (a @ b.transpose(0, 2, 1))
    return np.maximum(square, 0)


def _matern_across(a: Singles, b: Singles) -> Singles:
    """Prior covariance, shape (G, m, n)."""
    return matern(np.sqrt(np.float32(5) * _square_distances(a, b))).astype(np.float32, copy=False)


def _factor(features: Floats, noise: float, seen: NDArray[np.bool_]) -> Floats:
    """Cholesky factors of K + noise, shape (G, n, n); where a flight does not count, the row and the column of the identity."""
    both = seen[:, :, None] & seen[:, None]
    gram = matern(np.sqrt(5 * _square_distances(features, features))) * both
    diagonal = np.arange(gram.shape[1])
    gram[:, diagonal, diagonal] = np.where(seen, 1 + noise, 1.0)
    return np.asarray(np.linalg.cholesky(gram), dtype=np.float64)


def _standardise(values: Floats, seen: NDArray[np.bool_]) -> tuple[Floats, Floats, Floats]:
    """Mean and spread over the flights that count, each of shape (G, C), and standardised values, 0 where they do not count."""
    weights = seen[:, :, None] / np.maximum(seen.sum(axis=1), 1)[:, None, None]
    mean = (values * weights).sum(axis=1)
    centred = (values - mean[:, None]) * seen[:, :, None]
    spread = np.maximum(np.sqrt((centred**2 * weights).sum(axis=1)), LEAST_SPREAD)
    return mean, spread, centred / spread[:, None]
