"""Sensitivity: completion and cost when one tuned parameter is multiplied by a factor, in all segments or in one alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.reference.scenario import Scenario
from hotlap.tuning.scoring import Metric, score
from hotlap.worlds.world import World

Floats = NDArray[np.float64]

FACTORS = (0.25, 0.5, 0.5**0.5, 1.0, 2**0.5, 2.0, 4.0)
FLIGHTS = 4  # at each point
LITTLE, NONE = 0.02, 0.005  # of the gates: within the noise of so few flights, and none at all
BY_SEGMENT, FEWEST = 150, 1  # flights over all segments together, and at least at each point


@dataclass(frozen=True)
class Sensitivity:
    """How much each of K parameters matters around a tuned set; all flights meet the same noise.

    Attributes:
        factors: shape (N,) by which a parameter is multiplied; what leaves its bounds is moved to them.
        flights: at each point.
        completion: shape (K, N) mean completion when a parameter is multiplied in all segments.
        complete: shape (K, N) share of the flights that passed every gate.
        by_segment: shape (S, K) loss of mean completion, over a quarter and four times the parameter in that segment alone.
        cost: shape (K, N) mean cost, in the unit of the metric; less is better.
        cost_by_segment: shape (S, K) rise of the mean cost, likewise.
    """

    factors: Floats
    flights: int
    completion: Floats
    complete: Floats
    by_segment: Floats
    cost: Floats
    cost_by_segment: Floats

    @property
    def flat(self) -> bool:
        """Whether completion is the same whatever is changed, so that it tells nothing."""
        return float(np.ptp(self.completion)) < LITTLE

    @property
    def cost_tells(self) -> bool:
        """Whether the cost is shown over the factors, in place of completion that tells nothing."""
        return self.flat and bool(np.isfinite(self.cost).any())

    @property
    def cost_tells_by_segment(self) -> bool:
        """The same of changes in one segment alone."""
        return self.flat and float(np.abs(self.by_segment).max(initial=0.0)) < NONE and bool(np.isfinite(self.cost_by_segment).any())


def survey_sensitivity(
    scenario: Scenario, world: World, parameters: Parameters, seed: int, metric: Metric = Metric.TIME, flights: int = FLIGHTS
) -> Sensitivity:
    """Fly parameters, shape (S, K), changing one of them at a time.

    Args:
        scenario: what they were tuned on.
        world: where.
        parameters: shape (S, K).
        seed: of the run.
        metric: what the cost measures.
        flights: at each point of the curves.
    """
    factors, (segments, size) = np.array(FACTORS), parameters.shape
    curves = np.repeat(np.repeat(parameters[None, None], len(factors), axis=1), size, axis=0)  # (K, N, S, K)
    for k in range(size):
        curves[k, :, :, k] *= factors[:, None]
    single = np.tile(parameters, (segments, size, 2, 1, 1))  # (S, K, 2, S, K)
    for s, k in np.ndindex(segments, size):
        single[s, k, :, s, k] *= factors[[0, -1]]
    few = min(max(BY_SEGMENT // (2 * segments * size), FEWEST), flights)
    groups = (curves.reshape(-1, segments, size), flights), (single.reshape(-1, segments, size), few)
    (shares, costs), (parts, prices) = _fly(scenario, world, groups, seed, metric)
    here = FACTORS.index(1.0)
    curve, alone = (size, len(factors), flights), (segments, size, 2 * few)
    shares, costs, parts, prices = shares.reshape(curve), costs.reshape(curve), parts.reshape(alone), prices.reshape(alone)
    return Sensitivity(
        factors,
        flights,
        completion=shares.mean(axis=2),
        complete=(shares >= 1).mean(axis=2),
        by_segment=shares[0, here, :few].mean() - parts.mean(axis=2),
        cost=costs.mean(axis=2),
        cost_by_segment=prices.mean(axis=2) - costs[0, here, :few].mean(),
    )


def _fly(
    scenario: Scenario, world: World, groups: Sequence[tuple[Parameters, int]], seed: int, metric: Metric
) -> list[tuple[Floats, Floats]]:
    """Completion and cost at the points of each group, shape (points, flights) each; all fly in one batch, those that are the same once.

    Args:
        scenario: what is flown.
        world: where.
        groups: points, shape (points, S, K), and flights at each of them.
        seed: of the run.
        metric: what the cost measures.
    """
    distinct, indices, each, seeds = [], [], [], []
    for points, flights in groups:
        rows, index = np.unique(scenario.space.clip(points).reshape(len(points), -1), axis=0, return_inverse=True)
        distinct.append(len(rows))
        indices.append(index.reshape(-1))
        each.append(np.repeat(rows.reshape(-1, *points.shape[1:]), flights, axis=0))
        seeds.append(np.tile(flight_seeds(seed, Stream.DEMONSTRATION, 0, flights), len(rows)))
    flown = world.fly(scenario, np.concatenate(each), np.concatenate(seeds))
    ends = np.cumsum([len(one) for one in seeds])[:-1]
    found = flown.gates_passed / len(flown.gate_positions), score(flown, scenario.race.judge, metric).cost
    completion, cost = (
        [part.reshape(n, -1)[at] for part, n, at in zip(np.split(one, ends), distinct, indices, strict=True)] for one in found
    )
    return list(zip(completion, cost, strict=True))
