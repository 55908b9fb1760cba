"""World: anything that flies a course under our clock and says what happened."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hotlap.course import Course
from hotlap.parameters import Parameters
from hotlap.records import Flights


class World(Protocol):
    """Where flights happen.

    A flight's result depends on course, parameters, seed and truth alone: not on the batch, its order or its size.

    Attributes:
        name: what it is called.
        takes_truth: whether it can fly another vehicle than the race's; False for one that flies what it has.
    """

    name: str
    takes_truth: bool

    def fly(
        self,
        course: Course,
        parameters: Parameters,
        seeds: NDArray[np.int64],
        *,
        truth: NDArray[np.float64] | None = None,
        log: Sequence[int] = (),
    ) -> Flights:
        """Fly a batch, one closed-loop flight for each row.

        Args:
            course: what is flown.
            parameters: shape (B, S, K).
            seeds: shape (B,), not negative, below 2^53: the noise of each flight.
            truth: shape (B, P) physical parameters of the vehicle for each flight; None: the vehicle of the race.
            log: indices in the batch of the flights to record in full.
        """
        ...
