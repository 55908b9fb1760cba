"""Fit: the numbers with which the model's outputs come nearest to the log's, and how far each can be off.

Output error by least squares: the model flies the commands alone, so that no measured noise enters as a regressor. The residuals are
correlated in time, so the covariance is a sandwich (White 1980; Newey and West 1987): H^-1 S H^-1, with S the long-run covariance of the
scores by Bartlett's kernel, and Student's t in place of the normal distribution where few stretches of the log tell of an unknown. No
interval is narrower than with white residuals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import t as student

from hotlap.core.records import Floats
from hotlap.identification.model import Model
from hotlap.identification.unknowns import Unknown, starts

Mask = NDArray[np.bool_]

FIRST_SCALE = {"rates": 0.1, "force": 1.0, "velocity": 0.1}  # of what is left, before anything is fitted
LEAST_SCALE = 1e-4
NORMAL = 1.96  # standard deviations of a 95 % interval
TINY = 1e-300  # in place of 0
LARGEST = 12.0  # of a logarithm
STEP = 1e-4  # of finite differences
ROUNDS, EVALUATIONS = 3, 12  # of weights; of the outputs in each
OUTLIER = 6.0  # standard deviations, by the median
BIN, KERNEL = 0.02, 2.0  # s: over which scores are summed, and over which they may be correlated
DELAYS = tuple(0.01 * k for k in range(21))  # s that are tried first
GAINS = (0.3, 1.0, 3.0)  # times the gain of the base


@dataclass(frozen=True)
class Fit:
    """Numbers with their covariance.

    Attributes:
        unknowns: P of them.
        theta: shape (P,) as counted: logarithms where an unknown is one.
        covariance: shape (P, P).
        scales: root mean square of what is left, by channel, shape (3,) each.
    """

    unknowns: tuple[Unknown, ...]
    theta: Floats
    covariance: Floats
    scales: dict[str, Floats]

    @property
    def numbers(self) -> dict[str, float]:
        """Values by name, logarithms undone."""
        return numbers_of(self.unknowns, self.theta)

    def error(self, name: str) -> float:
        """Half width of the 95 % interval, as counted."""
        k = [one.name for one in self.unknowns].index(name)
        return NORMAL * math.sqrt(max(float(self.covariance[k, k]), 0.0))


def numbers_of(unknowns: Sequence[Unknown], theta: Floats) -> dict[str, float]:
    """Values by name, logarithms undone."""
    pairs = zip(unknowns, theta.tolist(), strict=True)
    return {one.name: math.exp(min(max(value, -LARGEST), LARGEST)) if one.is_log else value for one, value in pairs}


def search(models: Sequence[Model], unknowns: Sequence[Unknown]) -> dict[str, float]:
    """Where to begin: the thrust that hovers, and the dead time and rate gains that come nearest, by trying.

    Returns:
        Starts by name, as counted.
    """
    found = {one.name: one.start for one in unknowns}
    throttles = [m.evidence.flown(m.evidence.thrust_command)[:, 0] for m in models if m.evidence.thrust_command is not None]
    if throttles:
        hover = max(float(np.median(np.concatenate(throttles))), 0.02)
        c = found.get("curvature", 0.0)
        curve = (1 - c) * hover + c * hover**2
        found["full"] = math.log(models[0].base.gravity / curve)
    tried = []
    for gain in GAINS:
        for delay in DELAYS:
            theta = {**found, "delay": delay}
            theta |= {name: value + math.log(gain) for name, value in found.items() if name.startswith("gain_")}
            numbers = numbers_of(unknowns, np.array([theta[one.name] for one in unknowns]))
            cost = sum(float((m.rates_left(numbers) ** 2).sum()) for m in models)
            tried.append((cost, theta))
    return min(tried, key=lambda one: one[0])[1]


class _Problem:
    """Weighted residuals of all logs, and their derivatives."""

    def __init__(self, models: Sequence[Model], unknowns: Sequence[Unknown], counts: Sequence[dict[str, Mask]]) -> None:
        self.models, self.unknowns, self.counts = models, unknowns, list(counts)
        self.scales = {name: np.full(3, scale) for name, scale in FIRST_SCALE.items()}
        self._start, self._belief = starts(unknowns), np.array([one.belief for one in unknowns])

    def residuals(self, theta: Floats) -> Floats:
        """All that is left, then how far theta is from what was believed."""
        numbers, parts = numbers_of(self.unknowns, theta), []
        for model, counts in zip(self.models, self.counts, strict=True):
            left = model.left(numbers).items()
            parts += [(one[counts[name]] / self.scales[name]).ravel() for name, one in left if name in counts]
        return np.concatenate([*parts, (theta - self._start) / self._belief])

    def jacobian(self, theta: Floats) -> Floats:
        """Derivatives by forward differences."""
        before = self.residuals(theta)
        columns = []
        for k in range(len(self.unknowns)):
            changed = theta.copy()
            changed[k] += STEP
            columns.append((self.residuals(changed) - before) / STEP)
        return np.column_stack(columns)

    def reweigh(self, theta: Floats) -> None:
        """Take the weights from what is left, and leave out what lies far outside."""
        numbers, gathered = numbers_of(self.unknowns, theta), dict[str, list[Floats]]()
        for k, model in enumerate(self.models):
            for name, left in model.left(numbers).items():
                if name not in self.counts[k]:
                    continue
                spread = 1.4826 * np.median(np.abs(left[self.counts[k][name]]), axis=0) + LEAST_SCALE
                within = (np.abs(left) < OUTLIER * np.maximum(spread, 0.5 * self.scales[name])).all(axis=1)
                gathered.setdefault(name, []).append(left[self.counts[k][name] & within])
        for name, parts in gathered.items():
            self.scales[name] = np.sqrt(np.mean(np.vstack(parts) ** 2, axis=0)) + LEAST_SCALE

    def scores(self, jacobian: Floats, residuals: Floats, length: float = BIN) -> list[Floats]:
        """Sums of derivative times residual over times of a length [s], shape (bins, P) of each log."""
        found, at = [], 0
        for model, counts in zip(self.models, self.counts, strict=True):
            begin = model.evidence.grid[0]
            sums = np.zeros((int((model.evidence.grid[-1] - begin) / length) + 1, len(self.unknowns)))
            signals = {"rates": model.evidence.rates, "force": model.evidence.force, "velocity": model.evidence.velocity}
            for name, signal in signals.items():
                if signal is None or name not in counts:
                    continue
                times = np.repeat(signal.times[counts[name]], 3)
                rows = slice(at, at + len(times))
                bins = np.clip(((times - begin) / length).astype(np.int64), 0, len(sums) - 1)
                np.add.at(sums, bins, jacobian[rows] * residuals[rows, None])
                at += len(times)
            found.append(sums)
        return found


def fit(
    models: Sequence[Model], unknowns: Sequence[Unknown], theta: Floats, counts: Sequence[dict[str, Mask]], rounds: int = ROUNDS
) -> Fit:
    """Fit all unknowns to all logs.

    Args:
        models: one of each log.
        unknowns: P of them; what is believed before is their starts.
        theta: shape (P,) where to begin.
        counts: which samples count, by channel, of each log; a channel that is missing does not count.
        rounds: of weights.
    """
    problem = _Problem(models, unknowns, counts)
    for _ in range(rounds):
        problem.reweigh(theta)
        kept: dict[str, Any] = {"jac": problem.jacobian, "max_nfev": EVALUATIONS, "ftol": 1e-6, "xtol": 1e-6}
        theta = least_squares(problem.residuals, theta, method="lm", x_scale="jac", **kept).x
    problem.reweigh(theta)
    residuals, jacobian = problem.residuals(theta), problem.jacobian(theta)
    bread = np.linalg.inv(jacobian.T @ jacobian)
    scores = problem.scores(jacobian, residuals)
    believed = np.diag(np.array([one.belief for one in unknowns]) ** -2.0)
    sandwich = bread @ (sum(_long_run(one) for one in scores) + believed) @ bread
    wide = _widening(problem, jacobian @ bread)
    wanted = np.maximum(np.diag(bread), np.diag(sandwich) * wide**2)
    spread = np.sqrt(wanted / np.diag(sandwich))
    return Fit(tuple(unknowns), theta, sandwich * np.outer(spread, spread), problem.scales)


def _widening(problem: _Problem, influence: Floats) -> Floats:
    """By how much intervals are wider than normal ones because few stretches of a log tell of an unknown, shape (P,).

    Student's t with as many degrees of freedom as stretches tell of it alike: the participation ratio of their shares, less one.
    """
    total = np.vstack(problem.scores(influence**2, np.ones(len(influence)), KERNEL))
    alike = total.sum(axis=0) ** 2 / np.maximum((total**2).sum(axis=0), TINY)
    freedom = np.maximum(alike - 1, 2.0)
    return np.asarray(student.ppf(0.975, freedom) / NORMAL)


def _long_run(scores: Floats) -> Floats:
    """Long-run covariance of the sum of scores, shape (P, P), by Bartlett's kernel."""
    most = min(int(KERNEL / BIN), len(scores) - 1)
    total = scores.T @ scores
    for lag in range(1, most):
        crossed = scores[lag:].T @ scores[:-lag]
        total += (1 - lag / most) * (crossed + crossed.T)
    return np.asarray(total)
