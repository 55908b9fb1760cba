"""World: the protocol of everything that flies a scenario and records what happened; simulators and vehicles are worlds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hotlap.core.parameters import Parameters
from hotlap.core.records import Flights
from hotlap.reference.scenario import Scenario


class World(Protocol):
    """Where flights happen.

    A flight's result depends on scenario, parameters, seed and vehicle alone: not on the batch, its order or its size.

    Attributes:
        name: what it is called.
        takes_vehicle_parameters: whether it can fly another vehicle than the race's; False for one that flies what it has.
    """

    name: str
    takes_vehicle_parameters: bool

    def fly(
        self,
        scenario: Scenario,
        parameters: Parameters,
        seeds: NDArray[np.int64],
        *,
        vehicle_parameters: NDArray[np.float64] | None = None,
        log: Sequence[int] = (),
    ) -> Flights:
        """Fly a batch, one closed-loop flight for each row.

        Args:
            scenario: what is flown.
            parameters: shape (B, S, K).
            seeds: shape (B,), not negative, below 2^53: the noise of each flight.
            vehicle_parameters: shape (B, P) physical parameters of the vehicle for each flight; None: the vehicle of the race.
            log: indices in the batch of the flights to record in full.
        """
        ...


def is_slow(world: World) -> bool:
    """Whether flights of a world take seconds, so that none is flown for a picture: it says so by an attribute `slow`."""
    return bool(getattr(world, "slow", False))
