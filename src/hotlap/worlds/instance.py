"""Instance: a running simulator of a stepped world: opened when it is needed, closed when it was lost or another race is flown."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

from hotlap.core.counts import count
from hotlap.core.errors import InputError
from hotlap.reference.scenario import Scenario
from hotlap.worlds.clock import Clock
from hotlap.worlds.simulator import Simulator, SimulatorError

LOSSES = (SimulatorError, OSError, EOFError)
"""What a simulator raises that is lost; an own one may leave errors of its connection as they are."""
MOST_LOSSES = 3  # in a row

OpenSimulator = Callable[[Scenario, int], Simulator]


class Instance:
    """One simulator of a world.

    Args:
        name: of the world.
        open_simulator: (scenario, number of the instance) -> a simulator.
        number: of the instance.
    """

    def __init__(self, name: str, open_simulator: OpenSimulator, number: int) -> None:
        self._name, self._open, self._number = name, open_simulator, number
        self._simulator: Simulator | None = None
        self._raced: Any = None
        self._losses = 0

    def simulator(self, scenario: Scenario) -> tuple[Simulator, Clock]:
        """The simulator, opened for the race of a scenario, and its clock.

        Raises:
            InputError: it cannot be opened, or its steps make no control periods.
        """
        race = scenario.race
        raced = race.track, race.vehicle, race.control_model, race.controller
        if self._simulator is None or raced != self._raced:
            self.close()
            try:
                self._simulator, self._raced = self._open(scenario, self._number), raced
            except LOSSES as error:
                raise InputError("", "on", f"{error}") from error
        own = getattr(self._simulator, "delay", 0.0)  # whoever has none need not say so
        clock = Clock(self._simulator.step, race.controller.period, max(race.vehicle.delay - own, 0.0))
        clock.check(self._name, self._simulator.lanes)
        return self._simulator, clock

    def lose(self, error: Exception) -> None:
        """Close a simulator that was lost; the next flight opens it anew.

        Raises:
            InputError: it was lost time and again, and no flight between came to its end.
        """
        self.close()
        self._losses += 1
        if self._losses >= MOST_LOSSES:
            self._losses = 0
            raise InputError("", "on", f"{self._name} was lost {count(MOST_LOSSES, 'time')} in a row: {error}") from error

    def has_flown(self) -> None:
        """A flight came to its end."""
        self._losses = 0

    def close(self) -> None:
        """Close the simulator, if it is open; whatever it says to that."""
        simulator, self._simulator = self._simulator, None
        if simulator is not None:
            with suppress(*LOSSES):
                simulator.close()
