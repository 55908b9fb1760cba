"""Landscape: completion as a function of two parameters, the others fixed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.analysis.learning import built_in_world
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.planning.preparation import prepare
from hotlap.race.race import Race
from hotlap.reference.scenario import Scenario
from hotlap.tuning.objective import Objective
from hotlap.worlds.world import World

Floats = NDArray[np.float64]

TOGETHER = 2000  # flights in a batch, so that every thread has its share


@dataclass(frozen=True)
class Landscape:
    """Which map of completion is wanted.

    Attributes:
        race: what is flown.
        x, y: names of the parameters that vary, the same in all segments.
        points: along each, evenly in logarithms from bound to bound.
        flights: at each point, with the same noise at all of them.
        fixed: K parameters that give the values of the others; empty for the controller's default.
    """

    race: Race
    x: str
    y: str
    points: int = 50
    flights: int = 4
    fixed: tuple[float, ...] = ()


def axes(scenario: Scenario, wanted: Landscape) -> tuple[Floats, Floats]:
    """Values along x and y, shape (points,)."""
    space = scenario.space
    pair = [space.names.index(name) for name in (wanted.x, wanted.y)]
    ends = [(space.low[i], space.high[i]) for i in pair]
    return np.geomspace(*ends[0], wanted.points), np.geomspace(*ends[1], wanted.points)


def survey(scenario: Scenario, world: World, wanted: Landscape, watch: Callable[[str], None] = lambda _: None) -> Floats:
    """Mean completion, 0 to 1, shape (points, points): a row for each y, a column for each x.

    Args:
        scenario: what is flown.
        world: where.
        wanted: which map.
        watch: called with a few words after each row.
    """
    space = scenario.space
    x, y = axes(scenario, wanted)
    grid = np.tile(np.array(wanted.fixed) if wanted.fixed else space.default, (wanted.points, wanted.points, 1))
    grid[:, :, space.names.index(wanted.x)] = x
    grid[:, :, space.names.index(wanted.y)] = y[:, None]
    objective, parts = Objective(scenario, world), []
    together = max(1, TOGETHER // (wanted.points * wanted.flights))
    for first in range(0, wanted.points, together):
        flat = np.repeat(grid[first : first + together].reshape(-1, 1, space.size), len(scenario.segments), axis=1)
        seeds = np.tile(flight_seeds(0, Stream.DEMONSTRATION, 0, wanted.flights), len(flat))
        completion = objective.fly(np.repeat(flat, wanted.flights, axis=0), seeds).completion
        parts.append(completion.reshape(-1, wanted.points, wanted.flights).mean(axis=2))
        for value in y[first : first + together].tolist():
            watch(f"{wanted.y} {value:.3g}")
    return np.concatenate(parts)


def draw_survey(wanted: Landscape) -> Iterator[list[list[float]]]:
    """The map as a piece of work for `ResumableJobs`, rounded to a thousandth."""
    yield np.round(survey(prepare(wanted.race), built_in_world(), wanted), 3).tolist()
