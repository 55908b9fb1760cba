"""A vehicle that is flown open loop, by the compiled plant that flies it in the built-in world, in float64."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from hotlap.flight.detailed_plant import allocate_detailed_state, detailed_autopilot_numbers, detailed_vehicle_numbers
from hotlap.flight.lanes import as_numbers, borrow
from hotlap.flight.plant import allocate_vehicle_state
from hotlap.flight.plants import plant_functions, plant_numbers
from hotlap.race.plant_kind import PLAIN, detailed_kind, plant_kind_of
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import PLANT_STEP
from hotlap.race.vehicle_parameters import vehicle_parameters_of

from .kept import kept

REST = np.array([0.0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0])


class OpenLoop:
    """A vehicle in one lane.

    Args:
        quadrotor: that flies; its dead time outside of the rate loop is left out.
        state: shape (13,), where it begins.
        thrust: [N] of each rotor there; None: in hover.
        step: [s] of a detailed plant.
    """

    def __init__(self, quadrotor: Quadrotor, state: Any = REST, thrust: float | None = None, step: float = PLANT_STEP) -> None:
        kind, parameters = plant_kind_of(quadrotor), vehicle_parameters_of(quadrotor)[None]
        self.rotors, self._fly = quadrotor.rotor_count, flier(kind)
        if kind == PLAIN:
            self.memory: Any = allocate_vehicle_state(1, np.float64)
            vehicle, autopilot = plant_numbers(parameters, quadrotor, quadrotor)
        else:
            self.memory = allocate_detailed_state(detailed_kind(kind), quadrotor.rate_delay, 1, np.float64, step)
            vehicle, autopilot = (
                detailed_vehicle_numbers(parameters, quadrotor, step),
                detailed_autopilot_numbers(quadrotor, quadrotor, step),
            )
        self.memory.vehicle[:, 0], self.memory.autopilot[:, 0] = vehicle[0], autopilot
        self.memory.disturbance[0], self.memory.step[:] = 1.0, step
        self.memory.state[:13, 0] = state
        each = quadrotor.mass * quadrotor.gravity / self.rotors if thrust is None else thrust
        self.memory.state[13:17, 0] = np.sqrt(each * self.rotors / 4)
        plant_functions(kind).settle(self.memory, 0)

    @property
    def state(self) -> np.ndarray:
        """Position, attitude, velocity and body rates now, shape (13,)."""
        return self.memory.state[:13, 0].copy()

    @property
    def thrusts(self) -> np.ndarray:
        """Thrusts of the rotors at rest, shape (n,) [N]."""
        return self.memory.state[13 : 13 + self.rotors, 0] ** 2

    def fly(self, command: Any, steps: int = 1) -> np.ndarray:
        """Fly some steps under a command, thrust per mass and body rates; states after each, shape (steps, 13)."""
        self.memory.acting[:, 0] = command
        states = []
        for _ in range(steps):
            self._fly(self.memory, 1)
            states.append(self.state)
        return np.array(states)


@cache
def flier(kind: str) -> Any:
    """The compiled control period of a kind of plant on raw memory of one lane."""
    fly_period = plant_functions(kind).fly_period

    def fly(memory: Any, steps: int) -> None:
        fly_period(as_numbers(borrow(memory), 0), steps)

    return kept(fly, kind)
