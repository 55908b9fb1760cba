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
from hotlap.system.engine import Engine
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


@dataclass(frozen=True)
class Rows:
    """Some rows of a map.

    Attributes:
        scenario: what is flown.
        wanted: which map.
        first, last: of the rows; the last is not among them.
    """

    scenario: Scenario
    wanted: Landscape
    first: int
    last: int


def survey(
    scenario: Scenario, world: World, wanted: Landscape, watch: Callable[[str], None] = lambda _: None, engine: Engine | None = None
) -> Floats:
    """Mean completion, 0 to 1, shape (points, points): a row for each y, a column for each x.

    Args:
        scenario: what is flown.
        world: where, without an engine.
        wanted: which map.
        watch: called with a few words after each row.
        engine: whose workers fly the rows in the built-in world; None: this process does.
    """
    together = 1 if engine is not None else max(1, TOGETHER // (wanted.points * wanted.flights))
    pieces = [Rows(scenario, wanted, first, min(first + together, wanted.points)) for first in range(0, wanted.points, together)]
    flown = ((rows, _fly(rows, world)) for rows in pieces) if engine is None else engine.spread(fly_rows, pieces)
    found, y = np.empty((wanted.points, wanted.points)), axes(scenario, wanted)[1]
    for rows, completion in flown:
        found[rows.first : rows.last] = completion
        for value in y[rows.first : rows.last].tolist():
            watch(f"{wanted.y} {value:.3g}")
    return found


def fly_rows(rows: Rows) -> Iterator[Floats]:
    """Some rows, on a worker."""
    yield _fly(rows, built_in_world())


def _fly(rows: Rows, world: World) -> Floats:
    """Mean completion of some rows, shape (rows, points)."""
    scenario, wanted = rows.scenario, rows.wanted
    space = scenario.space
    x, y = axes(scenario, wanted)
    y = y[rows.first : rows.last]
    grid = np.tile(np.array(wanted.fixed) if wanted.fixed else space.default, (len(y), wanted.points, 1))
    grid[:, :, space.names.index(wanted.x)] = x
    grid[:, :, space.names.index(wanted.y)] = y[:, None]
    flat = np.repeat(grid.reshape(-1, 1, space.size), len(scenario.segments), axis=1)
    seeds = np.tile(flight_seeds(0, Stream.DEMONSTRATION, 0, wanted.flights), len(flat))
    completion = Objective(scenario, world).fly(np.repeat(flat, wanted.flights, axis=0), seeds).completion
    return completion.reshape(-1, wanted.points, wanted.flights).mean(axis=2)


def draw_survey(wanted: Landscape) -> Iterator[list[list[float]]]:
    """The map as a piece of work for `ResumableJobs`, rounded to a thousandth."""
    yield np.round(survey(prepare(wanted.race), built_in_world(), wanted), 3).tolist()
