"""Every flight of every run has noise of its own, fixed by run, purpose and number."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from hotlap.core.seeds import FLIGHTS_A_STREAM, LARGEST_RUN_SEED, SELECTIONS_A_RUN, Stream, flight_seeds


def test_no_two_flights_share_a_seed():
    seeds = np.concatenate([flight_seeds(run, stream, 0, 2000) for run in range(5) for stream in Stream])
    assert len(np.unique(seeds)) == 5 * len(Stream) * 2000


def last_of(stream: Stream) -> int:
    return (SELECTIONS_A_RUN if stream is Stream.SELECTION else FLIGHTS_A_STREAM) - 1


def test_streams_do_not_run_into_each_other():
    runs = (0, 1, LARGEST_RUN_SEED - 1, LARGEST_RUN_SEED)
    ends = sorted((flight_seeds(run, each, 0, 1)[0], flight_seeds(run, each, last_of(each), 1)[0]) for run in runs for each in Stream)
    assert all(last < first for (_, last), (first, _) in pairwise(ends))


def test_a_seed_depends_on_the_number_alone_not_on_the_batch():
    together = flight_seeds(7, Stream.SEARCH, 0, 10)
    np.testing.assert_array_equal(together, np.concatenate([flight_seeds(7, Stream.SEARCH, k, 1) for k in range(10)]))


def test_the_largest_seed_is_exact_in_json():
    assert all(flight_seeds(LARGEST_RUN_SEED, stream, last_of(stream), 1)[0] < 2**53 for stream in Stream)
    assert flight_seeds(0, Stream.SEARCH, 0, 3).tolist() == [0, 1, 2]
