"""Weighted maximum likelihood (WML): episodic policy search for a controller's high-level parameters.

Song, Scaramuzza, "Policy search for model predictive control with application to agile drone flight", IEEE T-RO 2022; for the
weights of a racing controller: Romero and others, "Weighted maximum likelihood for controller tuning", ICRA 2023. A Gaussian policy
over parameters is sampled, every sample is weighted by its reward, and the policy is fitted to the weighted samples in closed form.
Here the policy is Gaussian in logarithms and the reward is R = -log(1 + cost), so that one crash does not make all other rewards equal.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters, ParameterSpace, reflect
from hotlap.core.records import Scores
from hotlap.tuners.offsets import Offsets

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class WeightedLikelihoodSettings:
    """Settings of the policy search.

    Attributes:
        samples: N, flights of an iteration: few, so that 200 flights allow twenty fits.
        greed: beta times the range of the rewards in an iteration; the weight of the worst sample is exp(-greed) of that of the best.
        sigma: first standard deviation, in natural logarithms times the space's `log_step`.
        floor: standard deviation that is added to every fit, in the same unit, so that exploration does not end.
        tied: one step for all segments.
        dense: use the dense cost, else the metric.
    """

    samples: int = 10
    greed: float = 10.0
    sigma: float = 0.5
    floor: float = 0.1
    tied: bool = True
    dense: bool = False


PRESETS: Mapping[str, WeightedLikelihoodSettings] = {
    "tied": WeightedLikelihoodSettings(),
    "segments": WeightedLikelihoodSettings(samples=20, tied=False),
    "dense": WeightedLikelihoodSettings(dense=True),
}


@dataclass(frozen=True)
class Policy:
    """Gaussian distribution of offsets from the first guess.

    Attributes:
        mean: shape (d,).
        covariance: shape (d, d).
    """

    mean: Floats
    covariance: Floats

    def draw(self, count: int, rng: np.random.Generator) -> Floats:
        """Samples, shape (count, d)."""
        factor = np.linalg.cholesky(self.covariance)
        return self.mean + rng.standard_normal((count, len(self.mean))) @ factor.T

    def fit(self, samples: Floats, weights: Floats, floor: float) -> Policy:
        """The policy of maximum weighted likelihood.

        Differs from the papers, which have more samples than dimensions: here the old covariance counts as d samples, the least that keeps
        the new one regular, and `floor` squared is added on the diagonal.

        Args:
            samples: shape (N, d).
            weights: shape (N,), positive.
            floor: standard deviation.
        """
        size, total = len(self.mean), weights.sum()
        effective = total**2 / (weights**2).sum()  # effective sample size, Kish, 1965
        mean = weights @ samples / total  # mu = sum d_i z_i / sum d_i
        strayed = samples - mean
        normaliser = total - (weights**2).sum() / total  # Z = ((sum d)^2 - sum d^2) / sum d, Deisenroth, Neumann, Peters, 2013
        scatter = (weights[:, None] * strayed).T @ strayed / normaliser  # Sigma = sum d_i (z_i - mu)(z_i - mu)' / Z
        share = effective / (effective + size)
        return Policy(mean, share * (scatter + floor**2 * np.eye(size)) + (1 - share) * self.covariance)


def weigh(costs: Floats, greed: float) -> Floats:
    """d_i = exp(beta (R_i - max R)), beta = greed / (max R - min R), shape (N,); all 1 where no cost differs.

    A range that sets beta: Theodorou, Buchli, Schaal, JMLR 2010, with 10 for `greed`.

    Args:
        costs: shape (N,), lower is better; one that is not finite counts as the largest finite one.
        greed: logarithm of the ratio of the best weight to the worst.
    """
    finite = np.isfinite(costs)
    if not finite.any():
        return np.ones(len(costs))
    rewards = -np.log1p(np.maximum(np.where(finite, costs, costs[finite].max()), 0.0))
    spread = rewards.max() - rewards.min()
    return np.exp(greed * (rewards - rewards.max()) / spread) if spread > 0 else np.ones(len(costs))


class WeightedLikelihood:
    """One iteration after the other; the first sample of the first one is the first guess, the mean of the first policy."""

    def __init__(self, name: str, settings: WeightedLikelihoodSettings) -> None:
        self.name, self.settings = name, settings

    def start(self, first_guess: Parameters, space: ParameterSpace, rng: np.random.Generator) -> None:
        """Begin around the first guess."""
        self._rng, self._offsets = rng, Offsets(space, space.clip(first_guess), self.settings.tied)
        self._low, self._high = self._offsets.bounds
        size = len(self._low)
        self._policy = Policy(np.zeros(size), self.settings.sigma**2 * np.eye(size))
        self._best, self._costs = math.inf, [0.0][:0]
        self._samples = self._draw()
        self._samples[0] = 0.0

    def ask(self, n: int) -> Parameters:
        """The rest of an iteration, at most n, shape (1 to n, S, K); the same until the scores are reported."""
        flown = len(self._costs)
        return self._offsets.decode(self._samples[flown : flown + n])

    def tell(self, parameters: Parameters, scores: Scores) -> NDArray[np.bool_]:  # noqa: ARG002  they were asked for in order
        """Collect an iteration and, when it is complete, fit the policy. True where a flight has the lowest cost so far."""
        costs = (scores.dense if self.settings.dense else scores.cost).tolist()
        better = []
        for cost in costs:
            better.append(math.isfinite(cost) and cost <= self._best)
            self._best = cost if better[-1] else self._best
        self._costs += costs
        if len(self._costs) == len(self._samples):
            self._improve()
        return np.array(better, dtype=np.bool_)

    def state(self) -> dict[str, Any]:
        """The policy, the current iteration and the random generator."""
        return {
            "mean": self._policy.mean.tolist(),
            "covariance": self._policy.covariance.tolist(),
            "samples": self._samples.tolist(),
            "costs": [_plain(cost) for cost in self._costs],
            "best": _plain(self._best),
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from a `state()`."""
        self._policy = Policy(np.array(state["mean"]), np.array(state["covariance"]))
        self._samples = np.array(state["samples"])
        self._costs = [math.inf if cost is None else cost for cost in state["costs"]]
        self._best = math.inf if state["best"] is None else state["best"]
        self._rng.bit_generator.state = state["rng"]

    def _improve(self) -> None:
        """Fit the policy, unless all costs of the iteration are equal, and draw the next iteration."""
        weights = weigh(np.array(self._costs), self.settings.greed)
        if (weights < 1).any():
            self._policy = self._policy.fit(self._samples, weights, self.settings.floor)
        self._samples, self._costs = self._draw(), []

    def _draw(self) -> Floats:
        """Samples, mirrored at the bounds, shape (N, d)."""
        return reflect(self._policy.draw(self.settings.samples, self._rng), self._low, self._high)


def _plain(cost: float) -> float | None:
    """A cost as JSON, which has no infinity."""
    return cost if math.isfinite(cost) else None
