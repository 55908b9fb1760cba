"""On workers: the world of a simulator that workers of an engine open, each one of its own; a batch is spread over them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hotlap import worlds
from hotlap.core.errors import HotlapError
from hotlap.core.parameters import Parameters
from hotlap.core.records import Flights, Log
from hotlap.reference.scenario import Scenario
from hotlap.system.engine import Engine
from hotlap.worlds.simulator import Simulator
from hotlap.worlds.stepped import Stepped

if TYPE_CHECKING:
    from hotlap.worlds.world import World

EACH, MOST = 4, 8  # sorties of a worker, where a batch is long; flights of a lane in a sortie, at most: all of them carry the reference
OF_ALL = ("rooms", "gate_positions", "gate_times", "gate_segments", "logs")
"""Fields of `Flights` that do not have a row for each flight."""


@dataclass(frozen=True)
class Sortie:
    """Some flights of a batch, for one simulator.

    Attributes:
        world: its name.
        scenario: what is flown.
        first: index in the batch of the first of them.
        parameters: shape (L, S, K).
        seeds: shape (L,).
        log: indices among them of those to record in full.
    """

    world: str
    scenario: Scenario
    first: int
    parameters: Parameters
    seeds: NDArray[np.int64]
    log: tuple[int, ...]


class OnWorkers(Stepped):
    """Flies in simulators that workers open, each its own; flights are those of `Stepped`, with as many instances, bit for bit.

    Args:
        name: of the world, as workers find it, too.
        instances: simulators by which its capacity is told; as many flights are flown at once as there are workers.
        engine: whose workers fly.

    Attributes:
        engine: likewise.
    """

    def __init__(self, name: str, instances: int, engine: Engine) -> None:
        super().__init__(name, _open_nowhere, instances)
        self.engine, self._lanes = engine, 0

    def capacity(self, scenario: Scenario) -> int:
        """Lanes of so many instances; lets a worker open one.

        Raises:
            InputError: it cannot be opened.
        """
        if not self._lanes:
            [(_, self._lanes)] = self.engine.spread(tell_lanes, [(self.name, scenario)])
        return self._lanes * self.instances

    def needs_compiling(self, scenario: Scenario) -> bool:  # noqa: ARG002
        """Never here: workers compile the controller."""
        return False

    def prepare(self, scenario: Scenario) -> None:
        """Nothing: workers compile the controller."""

    def open(self, scenario: Scenario) -> None:
        """Let a worker open a simulator, so that one that is not there is told of before anything is flown.

        Raises:
            InputError: it cannot be opened.
        """
        self.capacity(scenario)

    def fly(
        self,
        scenario: Scenario,
        parameters: Parameters,
        seeds: NDArray[np.int64],
        *,
        vehicle_parameters: NDArray[np.float64] | None = None,
        log: Sequence[int] = (),
    ) -> Flights:
        """Fly a batch; see `World.fly`.

        Raises:
            HotlapError: vehicles that are to differ, or nobody to fly.
            InputError: a simulator cannot be opened, or was lost time and again.
        """
        if vehicle_parameters is not None:
            raise HotlapError(f"{self.name} flies the vehicle that it has")
        lanes = self.capacity(scenario) // self.instances
        step = lanes * min(max(len(seeds) // (lanes * self.engine.workers * EACH), 1), MOST)
        sorties = [
            Sortie(
                self.name,
                scenario,
                first,
                parameters[first : first + step],
                seeds[first : first + step],
                tuple(index - first for index in log if first <= index < first + step),
            )
            for first in range(0, max(1, len(seeds)), step)
        ]
        found: dict[int, Flights] = {}
        flown = 0
        for sortie, (flights, notes) in self.engine.spread(fly_sortie, sorties):
            found[sortie.first] = flights
            for note in notes:
                self.note(f"{self.name}: {note}")
            for _ in range(len(flights)):
                flown += 1
                self.watch(flown)
        return merge([found[sortie.first] for sortie in sorties])


def merge(parts: Sequence[Flights]) -> Flights:
    """Parts of a batch as one, in their order."""
    columns = {
        field.name: np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Flights) if field.name not in OF_ALL
    }
    logs: dict[int, Log] = {}
    before = 0
    for part in parts:
        logs |= {before + index: log for index, log in part.logs.items()}
        before += len(part)
    shared = {name: getattr(parts[0], name) for name in OF_ALL[:-1]}
    return Flights(**columns, **shared, logs=logs)


def tell_lanes(asked: tuple[str, Scenario]) -> Iterator[int]:
    """How many lanes a simulator has, on a worker."""
    name, scenario = asked
    yield simulators_here(name).capacity(scenario)


def fly_sortie(sortie: Sortie) -> Iterator[tuple[Flights, tuple[str, ...]]]:
    """Flights of a sortie, on a worker, and what was said about them."""
    world, notes = simulators_here(sortie.world), list[str]()
    world.note = lambda line: notes.append(line.removeprefix(f"{world.name}: "))
    yield world.fly(sortie.scenario, sortie.parameters, sortie.seeds, log=sortie.log), tuple(notes)


@cache
def simulators_here(name: str) -> Stepped:
    """The world of a worker, whose simulator stays open from one piece of work to the next."""
    world: World = worlds.build(name)
    assert isinstance(world, Stepped), "the built-in world is not spread"  # noqa: S101  our own mistake
    return world


def _open_nowhere(_scenario: Scenario, _instance: int) -> Simulator:
    """Simulators are opened by workers alone."""
    raise AssertionError("workers open it")
