"""The contest of two guesses with which a search may begin."""

import json

import numpy as np
import pytest

from hotlap import tuners
from hotlap.core.parameters import ParameterSpace
from hotlap.tuners.contest import FLIGHTS, Contest

from .laws import make_scores

SPACE = ParameterSpace(("a", "b"), np.array([1.0, 1.0]), np.array([100.0, 100.0]), np.array([10.0, 10.0]), np.array([1.0, 1.0]))
FIRST, RIVAL = np.full((2, 2), 10.0), np.full((2, 2), 20.0)


def begin() -> Contest:
    contest = Contest(tuners.build("random_search"), RIVAL)
    contest.start(FIRST, SPACE, np.random.default_rng(3))
    return contest


def fly(contest: Contest, good: float, n: int = 4) -> np.ndarray:
    """Ask and tell, where the cost is the distance from parameters that are good."""
    parameters = contest.ask(n)
    contest.tell(parameters, make_scores(np.abs(parameters - good).mean(axis=(1, 2))))
    return parameters


@pytest.mark.parametrize("n", [1, 4, 50])
@pytest.mark.parametrize(("good", "better"), [(10.0, FIRST), (15.0, FIRST), (20.0, RIVAL)])
def test_both_guesses_fly_in_turn_and_the_search_begins_at_the_better_one(good, better, n):
    contest, flown = begin(), np.empty((0, 2, 2))
    while len(flown) < 2 * FLIGHTS:
        flown = np.concatenate([flown, fly(contest, good, n)])
    np.testing.assert_array_equal(flown, np.array([FIRST, RIVAL] * FLIGHTS))
    np.testing.assert_array_equal(contest.ask(1)[0], better)


def test_what_is_stopped_within_or_after_the_contest_goes_on_the_same():
    whole, parts = begin(), begin()
    for _ in range(8):
        resumed = begin()
        resumed.restore(json.loads(json.dumps(parts.state(), allow_nan=False)))
        parts = resumed
        np.testing.assert_array_equal(fly(whole, 20.0), fly(parts, 20.0))


def test_a_guess_without_a_cost_loses():
    contest = begin()
    for _ in range(FLIGHTS):
        contest.tell(contest.ask(2), make_scores(np.array([np.inf, 1.0])))
    np.testing.assert_array_equal(contest.ask(1)[0], RIVAL)
    json.dumps(contest.state(), allow_nan=False)
