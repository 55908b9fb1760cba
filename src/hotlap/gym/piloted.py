"""Piloted: one flight of the built-in world whose commands come from outside; start, noise, dead time and judge are the world's."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from hotlap.core.records import Floats
from hotlap.flight.control_loop import ControlLoop
from hotlap.flight.job import Job, Settings
from hotlap.flight.kernel import Lane, actuate
from hotlap.flight.kernel_cache import keep
from hotlap.flight.lanes import borrow
from hotlap.flight.numbers import COMPILE
from hotlap.flight.one_flight import OneFlight, prepare_batch
from hotlap.flight.plant import VehicleState
from hotlap.reference.scenario import Scenario
from hotlap.worlds.clock import Clock
from hotlap.worlds.plant_simulator import PlantSimulator
from hotlap.worlds.simulator import Start


class PilotedFlight(OneFlight):
    """A flight that is flown by commands from outside.

    Args:
        scenario: that is flown.
        seed: of the noise.

    Attributes:
        state: shape (13,) where the drone is.
    """

    def __init__(self, scenario: Scenario, seed: int) -> None:
        parameters = scenario.space.first_guess(len(scenario.segments))[None]
        race, batch = scenario.race, prepare_batch(scenario, parameters, np.array([seed], dtype=np.int64))
        super().__init__(batch)
        floor = -np.inf if race.track.floor is None else race.track.floor
        self._simulator = PlantSimulator(race.vehicle, race.control_model, floor)
        self._clock = Clock(self._simulator.step, race.controller.period, race.vehicle.delay)
        self.state: Floats = self.begin(0)
        self._first = self.thrust_factor
        self._simulator.reset(0, Start(self.state, self._first))
        self._look()

    @property
    def gates_passed(self) -> int:
        """In a row from the first."""
        return int(self._batch.verdicts.gates_passed[0])

    def fly(self, command: Floats) -> bool:
        """Fly a control period.

        Args:
            command: shape (4,): thrust per mass [m/s^2] and body rates [rad/s].

        Returns:
            Whether the flight is over.
        """
        _give()(*self._told, self._loop, self._vehicle, self._lane, np.asarray(command, dtype=np.float64))
        steps, late = self._clock.steps_in(self.tick), min(self._clock.older_steps, self._clock.steps_in(self.tick))
        for acting, part in ((self._vehicle.older, late), (self._vehicle.acting, steps - late)):
            if part:
                told = acting[:, 0].copy()
                told[0] *= self.thrust_factor / self._first
                self._simulator.advance(told[None], part * self._clock.step)
        self.state = self._simulator.states()[0]
        return self.judge(self.state, self._simulator.rotor_thrusts()[0])

    def verdict(self) -> Any:
        """What has become of it: flights of one."""
        return self._batch.record()

    def _look(self) -> None:
        self.see(self.state, self._simulator.rotor_thrusts()[0])


@cache
def _give() -> Any:
    """The compiled function that lets a command act from now on, with the noise and the dead time of the world."""

    def give(job: Job, s: Settings, loop: ControlLoop, vehicle: VehicleState, lane: Lane, command: Any) -> None:
        """Put a command at the head of the history, and let it act."""
        loop = borrow(loop)
        for k in range(len(loop.history) - 1, 0, -1):
            for a in range(4):
                loop.history[k, a, 0] = loop.history[k - 1, a, 0]
        for a in range(4):
            loop.history[0, a, 0] = command[a]
        actuate(borrow(job), s, loop, borrow(vehicle), borrow(lane), 0)

    from numba import njit  # noqa: PLC0415  the flight core has to start it

    return keep(njit(**COMPILE)(give), "one-give")
