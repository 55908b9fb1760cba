"""A simulator of a user's own, as `--on worlds.own_simulator.Own` finds it: the built-in world's plant."""

from __future__ import annotations

import numpy as np

from hotlap.reference.scenario import Scenario
from hotlap.worlds.plant_simulator import PlantSimulator
from hotlap.worlds.simulator import SimulatorError

OPENED: list[tuple[int, str]] = []


class Own(PlantSimulator):
    """Simulates the vehicle of the race; its argument is how many at once."""

    def __init__(self, scenario: Scenario, instance: int, argument: str = "") -> None:
        OPENED.append((instance, argument))
        floor = -np.inf if scenario.race.track.floor is None else scenario.race.track.floor
        super().__init__(scenario.race.vehicle, scenario.race.control_model, floor, lanes=int(argument or 1))


NUMBER = 3


def cannot_open(*_: object) -> None:
    """Its program is missing."""
    raise SimulatorError("there is no such drone")
