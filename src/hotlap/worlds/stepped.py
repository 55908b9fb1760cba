"""Stepped: the world of a simulator that is stepped from outside: our clock, controller, noise, dead time, judge and log, its physics."""

from __future__ import annotations

import warnings
import weakref
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import HotlapError
from hotlap.core.parameters import Parameters
from hotlap.core.records import Flights
from hotlap.reference.scenario import Scenario
from hotlap.worlds.instance import Instance, OpenSimulator


class Stepped:
    """Flies in a simulator, in its lanes in lockstep, and in several simulators side by side.

    A flight's result depends on scenario, parameters, seed and simulator alone: not on batch, order, lane or instance.

    Args:
        name: of the world.
        open_simulator: (scenario, number of the instance) -> a simulator that is ready to be reset.
        instances: simulators side by side, each driven by a thread of its own.

    Attributes:
        name: of the world.
        takes_vehicle_parameters: False: a simulator flies what it has.
        instances: simulators side by side.
        note: called with a line when a simulator was lost.
        watch: called after each flight with how many of the batch have ended.
        slow: True: flights take seconds.
        opening: what it does while it is opened.
    """

    def __init__(self, name: str, open_simulator: OpenSimulator, instances: int = 1) -> None:
        self.name, self.instances, self.takes_vehicle_parameters = name, instances, False
        self.slow, self.opening = True, f"opening {name}"
        self.note: Callable[[str], None] = _warn
        self.watch: Callable[[int], None] = lambda _: None
        self._instances = [Instance(name, open_simulator, number) for number in range(instances)]
        weakref.finalize(self, _close_all, self._instances)

    def capacity(self, scenario: Scenario) -> int:
        """Flights at once: lanes of all instances; opens the first.

        Raises:
            InputError: it cannot be opened.
        """
        return self._instances[0].simulator(scenario)[0].lanes * self.instances

    def needs_compiling(self, scenario: Scenario) -> bool:
        """Whether the controller must be compiled before the next flight."""
        from hotlap.flight.one_flight import needs_compiling  # noqa: PLC0415  the flight core loads a compiler

        return needs_compiling(scenario.race.controller.law)

    def prepare(self, scenario: Scenario) -> None:
        """Compile the controller, or load it from the cache, by one control step."""
        from hotlap.flight.one_flight import OneFlight, prepare_batch  # noqa: PLC0415

        flight = OneFlight(prepare_batch(scenario, scenario.space.first_guess(len(scenario.segments))[None], np.zeros(1, dtype=np.int64)))
        state = flight.begin(0)
        flight.command()
        flight.judge(state, np.zeros(scenario.race.vehicle.rotor_count))
        flight.lose()

    def open(self, scenario: Scenario) -> None:
        """Open the first simulator for a race, so that one that is not there is told of before anything is flown.

        Raises:
            InputError: it cannot be opened.
        """
        self._instances[0].simulator(scenario)

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
            HotlapError: arrays that do not fit together, or vehicles that are to differ.
            InputError: a simulator cannot be opened, or was lost time and again.
        """
        from hotlap.flight.one_flight import prepare_batch  # noqa: PLC0415
        from hotlap.worlds.lockstep import FlightQueue, fly_queue  # noqa: PLC0415

        if vehicle_parameters is not None:
            raise HotlapError(f"{self.name} flies the vehicle that it has")
        batch, queue = prepare_batch(scenario, parameters, seeds, log), FlightQueue(len(seeds), self.watch)
        crew = self._instances[: max(1, len(seeds))]

        def fly_one(instance: Instance) -> None:
            """Fly what waits in one simulator; who fails stops all."""
            try:
                fly_queue(batch, instance, queue, lambda line: self.note(f"{self.name}: {line}"))
            except BaseException:
                queue.stop()
                raise

        try:
            if len(crew) == 1:
                fly_one(crew[0])
            else:
                _fly_side_by_side(fly_one, crew, queue.stop)
        except BaseException:
            self.close()
            raise
        return batch.record()

    def close(self) -> None:
        """Give back all simulators; the next flight opens them anew."""
        _close_all(self._instances)


def _fly_side_by_side(fly_one: Callable[[Instance], None], crew: Sequence[Instance], stop: Callable[[], None]) -> None:
    """Fly in several simulators, each driven by a thread of its own."""
    with ThreadPoolExecutor(len(crew)) as pool:
        flying = [pool.submit(fly_one, instance) for instance in crew]
        try:
            for thread in flying:
                thread.result()
        except BaseException:
            stop()
            raise


def _close_all(instances: Sequence[Instance]) -> None:
    for instance in instances:
        instance.close()


def _warn(line: str) -> None:
    warnings.warn(line, RuntimeWarning, stacklevel=2)
