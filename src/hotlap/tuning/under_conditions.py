"""Flights under conditions: another mass, less thrust, wind; and an objective that flies each candidate under several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters
from hotlap.core.records import Scores
from hotlap.race.conditions import Condition
from hotlap.race.race import NoiseSettings
from hotlap.race.vehicle_parameters import vehicle_parameters_of
from hotlap.reference.scenario import Scenario
from hotlap.tuning.objective import Objective
from hotlap.tuning.scoring import Metric, score
from hotlap.worlds.world import World


def fly_under(
    scenario: Scenario,
    world: World,
    parameters: Parameters,
    seeds: NDArray[np.int64],
    conditions: Sequence[Condition],
    metric: Metric = Metric.TIME,
) -> Scores:
    """Fly each flight under a condition of its own, those of the same noise in one batch; the scores in the order asked for.

    Args:
        scenario: what is flown.
        world: one that takes vehicle parameters for each flight.
        parameters: shape (B, S, K).
        seeds: shape (B,).
        conditions: B of them.
        metric: what the cost measures.
    """
    race, before = scenario.race, vehicle_parameters_of(scenario.race.vehicle)
    noises: dict[str, tuple[NoiseSettings, list[int]]] = {}
    for i, condition in enumerate(conditions):
        noise = condition.noise(race.noise)
        noises.setdefault(noise.fingerprint, (noise, []))[1].append(i)
    parts, order = [], []
    for noise, alike in noises.values():
        vehicles = np.stack([conditions[i].vehicle_parameters(before) for i in alike])
        noisy = replace(scenario, race=race.model_copy(update={"noise": noise}))
        parts.append(score(world.fly(noisy, parameters[alike], seeds[alike], vehicle_parameters=vehicles), race.judge, metric))
        order += alike
    return Scores.join(parts).rows(np.argsort(order))


@dataclass
class UnderConditions(Objective):
    """An objective whose flights take conditions in turn, each by its seed: as many flights of a candidate meet each of them once.

    Attributes:
        conditions: at least one.
    """

    conditions: tuple[Condition, ...] = ()

    def fly(self, parameters: Parameters, seeds: NDArray[np.int64]) -> Scores:
        """Fly parameters; the score of each flight."""
        conditions = [self.conditions[seed % len(self.conditions)] for seed in seeds.tolist()]
        self.flights += len(seeds)
        return fly_under(self.scenario, self.world, parameters, seeds, conditions, self.metric)
