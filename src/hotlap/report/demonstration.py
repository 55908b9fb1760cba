"""Demonstration: sets of parameters flown once more through the same noise, to be shown; nothing is chosen among these flights."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters
from hotlap.reference.scenario import Scenario
from hotlap.report.scene import Scene, repeat, stage, trace
from hotlap.worlds.world import World

BEST, FIRST, DEFAULT = "best", "first guess", "default"


@dataclass(frozen=True)
class ParameterSet:
    """What is flown.

    Attributes:
        label: what it is ("best").
        parameters: shape (S, K).
    """

    label: str
    parameters: Parameters


def choose(scenario: Scenario, first: Parameters, best: Parameters) -> tuple[ParameterSet, ...]:
    """The best parameters, the first guess and the controller's default, as far as they differ; the best come first.

    Args:
        scenario: what they belong to.
        first: shape (S, K).
        best: shape (S, K).
    """
    sets = [ParameterSet(BEST, best)]
    for label, values in ((FIRST, first), (DEFAULT, scenario.space.first_guess(len(scenario.segments)))):
        if not any(np.array_equal(values, known.parameters) for known in sets):
            sets.append(ParameterSet(label, values))
    return tuple(sets)


def demonstrate(scenario: Scenario, world: World, sets: Sequence[ParameterSet], seeds: NDArray[np.int64]) -> Scene:
    """Fly each of some parameters through the same noise, and record one flight of each.

    Args:
        scenario: what is flown.
        world: where.
        sets: at least one, the one that matters most first.
        seeds: shape (N,).
    """
    count = len(seeds)
    parameters = np.concatenate([np.repeat(one.parameters[None], count, axis=0) for one in sets])
    flown = world.fly(scenario, parameters, np.tile(seeds, len(sets)), log=[i * count for i in range(len(sets))])
    traces = tuple(trace(scenario, flown, i * count, one.label) for i, one in enumerate(sets))
    repeats = tuple(repeat(flown, slice(i * count, (i + 1) * count), one.label) for i, one in enumerate(sets))
    return stage(scenario, traces, repeats)
