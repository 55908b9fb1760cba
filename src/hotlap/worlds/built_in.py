"""The built-in world: the flight core, many flights at a time, thousands of times faster than real time."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import cached_property
from importlib.metadata import version
from platform import machine
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import HotlapError
from hotlap.core.parameters import Parameters
from hotlap.core.records import Flights
from hotlap.core.world_names import BUILT_IN
from hotlap.race.plant_kind import PLAIN, plant_kind_of
from hotlap.reference.scenario import Scenario

if TYPE_CHECKING:
    from hotlap.flight.fly import Effort
    from hotlap.flight.numbers import Numbers

UNSOUND = "compiled {} flights differ from interpreted ones, so flights are computed in float64, ten times slower: please report this"


class BuiltIn:
    """Flies in the flight core; its first flight on a machine compiles for half a minute.

    Args:
        numbers: kind of number that flights are computed in, of `flight.numbers.Numbers`; "": the fastest here.
        threads: how many; 0 for one a processor.

    Attributes:
        name: "built-in".
        takes_vehicle_parameters: True: it can fly any vehicle.
        threads: how many; 0 for one a processor.
        effort: what the last batch took.

    Lanes that do not pass their self-check are not flown: the world warns, and flies in float64.
    """

    def __init__(self, numbers: str = "", threads: int = 0) -> None:
        self.name, self.takes_vehicle_parameters = BUILT_IN, True
        self.effort: Effort | None = None
        self._numbers, self.threads = numbers, threads
        self._sound: dict[tuple[str, str], Numbers] = {}

    @cached_property
    def numbers(self) -> Numbers:
        """Kind of number that was asked for."""
        from hotlap.flight.numbers import Numbers, best_numbers  # noqa: PLC0415  the flight core loads a compiler

        return Numbers(self._numbers) if self._numbers else best_numbers()

    def needs_compiling(self, scenario: Scenario) -> bool:
        """Whether the kernel for a scenario must be compiled before its next flight."""
        from hotlap.flight import kernel, kernel_cache  # noqa: PLC0415

        return not kernel_cache.is_filled(kernel.worker(self.numbers, scenario.race.controller.law, plant_kind_of(scenario.race.vehicle)))

    def prepare(self, scenario: Scenario) -> None:
        """Compile the kernel, or load it from the cache, by flying once."""
        self.fly(scenario, scenario.space.first_guess(len(scenario.segments))[None], np.zeros(1, dtype=np.int64))

    def fly(
        self,
        scenario: Scenario,
        parameters: Parameters,
        seeds: NDArray[np.int64],
        *,
        vehicle_parameters: NDArray[np.float64] | None = None,
        log: Sequence[int] = (),
    ) -> Flights:
        """Fly a batch; see `World.fly`. The columns of `vehicle_parameters` are `vehicle_parameters.VEHICLE_PARAMETERS`."""
        from hotlap.flight.fly import fly_batch  # noqa: PLC0415

        numbers = self.sound_numbers(scenario.race.controller.law, plant_kind_of(scenario.race.vehicle))
        flights, self.effort = fly_batch(
            scenario, parameters, seeds, numbers=numbers, threads=self.threads, vehicle_parameters=vehicle_parameters, log=log
        )
        return flights

    def sound_numbers(self, law: str, plant: str = PLAIN) -> Numbers:
        """Kind of number that flights of a controller and a plant are computed in: what was asked for, unless it fails its self-check."""
        from hotlap.flight.numbers import Numbers  # noqa: PLC0415
        from hotlap.flight.self_check import agrees  # noqa: PLC0415

        if (law, plant) not in self._sound:
            try:
                sound = not self.numbers.width or agrees(self.numbers, law, plant)
                reason = f"{UNSOUND.format(self.numbers)} (numba {version('numba')}, {machine()})"
            except HotlapError as error:  # no second interpreter, for want of memory or of a program
                sound, reason = False, f"{error}, so flights are computed in float64, ten times slower"
            self._sound[law, plant] = self.numbers if sound else Numbers.FLOAT64
            if not sound:
                warnings.warn(reason, RuntimeWarning, stacklevel=3)
        return self._sound[law, plant]
