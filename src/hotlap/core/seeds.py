"""Seeds: the seed of a flight's noise, from the run's seed and the flight's number alone."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

LARGEST_RUN_SEED = 2**31 - 1
FLIGHTS_A_STREAM = 1_000_000
FORMER = 4  # streams that lie side by side for each run; seeds of later ones lie above all of theirs
SELECTIONS_A_RUN = 100_000  # flights of the stream SELECTION, so that its seeds are below 2^53, too


class Stream(IntEnum):
    """The purpose of a flight; no two streams share a seed."""

    SEARCH = 0
    CONFIRMATION = 1
    VALIDATION = 2
    DEMONSTRATION = 3
    SELECTION = 4


def flight_seeds(run_seed: int, stream: Stream, first: int, count: int) -> NDArray[np.int64]:
    """Seeds of consecutive flights of a stream: (4 run_seed + stream) * 10^6 + number; of SELECTION above all of these.

    Distinct by construction, readable, below 2^53 (exact in JSON), and independent of the tuner: the k-th search flight of a run
    meets the same noise whoever proposed it. Worlds hash them into noise.

    Args:
        run_seed: 0 to `LARGEST_RUN_SEED`.
        stream: what the flights are for.
        first: number of the first one within its stream.
        count: how many; the stream has `FLIGHTS_A_STREAM`, or `SELECTIONS_A_RUN`.

    Returns:
        Shape (count,).
    """
    numbers = np.arange(first, first + count, dtype=np.int64)
    if stream is Stream.SELECTION:
        return FORMER * (LARGEST_RUN_SEED + 1) * FLIGHTS_A_STREAM + run_seed * SELECTIONS_A_RUN + numbers
    return (FORMER * run_seed + stream) * FLIGHTS_A_STREAM + numbers
