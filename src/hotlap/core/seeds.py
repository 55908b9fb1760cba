"""Seeds: the seed of a flight's noise, from the run's seed and the flight's number alone."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

LARGEST_RUN_SEED = 2**31 - 1
FLIGHTS_A_STREAM = 1_000_000


class Stream(IntEnum):
    """The purpose of a flight; no two streams share a seed."""

    SEARCH = 0
    CONFIRMATION = 1
    VALIDATION = 2
    DEMONSTRATION = 3


def flight_seeds(run_seed: int, stream: Stream, first: int, count: int) -> NDArray[np.int64]:
    """Seeds of consecutive flights of a stream: (4 run_seed + stream) * 10^6 + number.

    Distinct by construction, readable, below 2^53 (exact in JSON), and independent of the tuner: the k-th search flight of a run
    meets the same noise whoever proposed it. Worlds hash them into noise.

    Args:
        run_seed: 0 to `LARGEST_RUN_SEED`.
        stream: what the flights are for.
        first: number of the first one within its stream.
        count: how many; the stream has `FLIGHTS_A_STREAM`.

    Returns:
        Shape (count,).
    """
    return (len(Stream) * run_seed + stream) * FLIGHTS_A_STREAM + np.arange(first, first + count, dtype=np.int64)
