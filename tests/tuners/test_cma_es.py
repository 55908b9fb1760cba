"""CMA-ES gathers generations, restarts, and begins where it is told to."""

import cma
import numpy as np
import pytest

from hotlap import tuners

from .laws import make_scores
from .test_contract import SPACE, judge, play, start


def test_the_first_generation_lies_around_the_first_guess():
    tuner = start("cma_es:log")
    asked = np.log(play(tuner, 200, scores=lambda p: make_scores(np.zeros(len(p))))[1:13] / SPACE.default)
    width = np.log(SPACE.high / SPACE.low)
    assert np.abs(asked / width).max() < 0.8
    assert 0.08 < (asked / width).std() < 0.2


def test_tied_moves_all_segments_alike():
    asked = play(start("cma_es:tied"), 40)
    assert (asked[1:] == asked[1:, :1]).all()
    assert not (play(start("cma_es:log"), 40)[1:] == asked[1:, :1]).all()


def test_a_generation_may_be_asked_for_in_pieces():
    np.testing.assert_array_equal(play(start("cma_es"), 60, n=7), play(start("cma_es"), 60, n=20))


def test_a_converged_run_begins_anew():
    tuner = start("cma_es:tied")
    first = tuner._strategy
    for _ in range(600):
        asked = tuner.ask(20)
        tuner.tell(asked, judge(asked))
        if tuner._strategy is not first:
            return
    pytest.fail("it never stopped")


def test_bipop_alternates_large_and_small_populations():
    tuner, sizes = start("cma_es:bipop"), []
    for _ in range(8):
        tuner._strategy._g = 10
        tuner._restart()
        sizes.append(tuner._strategy.population_size)
    ordinary = 4 + int(3 * np.log(15))
    assert max(sizes) >= 4 * ordinary
    assert min(sizes) < 2 * ordinary


def test_warm_start_looks_around_first_and_then_begins_where_it_was_best():
    tuner = start("cma_es:warm")
    play(tuner, 13, n=20)
    assert tuner._strategy is not None
    best = min(tuner._source, key=lambda flown: flown[1])[0]
    worst = max(tuner._source, key=lambda flown: flown[1])[0]
    mean = tuner._strategy._mean
    assert np.linalg.norm(mean - best) < np.linalg.norm(mean - worst)


def test_it_needs_as_many_flights_as_another_implementation():
    """On a sphere in the unit box; `cma` is Hansen's own."""

    def sphere(points):
        return ((np.asarray(points) - 0.3) ** 2).sum(axis=-1)

    ours, theirs = [], []
    for seed in range(1, 9):
        tuner = tuners.build("cma_es:log")
        tuner.start(SPACE.first_guess(1), SPACE, np.random.default_rng(seed))
        flights = 0
        while True:
            asked = tuner.ask(8)
            costs = sphere(SPACE.to_unit(asked)[:, 0])
            tuner.tell(asked, make_scores(costs))
            flights += len(asked)
            if costs.min() < 1e-6:
                break
        ours.append(flights)
        start_at = SPACE.to_unit(SPACE.first_guess(1))[0]
        options = {"bounds": [0, 1], "seed": seed, "verbose": -9, "ftarget": 1e-6}
        theirs.append(cma.fmin2(lambda x: float(sphere(x)), start_at, 0.15, options)[1].result.evaluations)
    assert 0.6 < np.median(ours) / np.median(theirs) < 1.6
