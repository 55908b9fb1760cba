"""Each flight of a run counts at its own number, from the first guess on."""

from __future__ import annotations

import numpy as np
import pytest

from fake_world import FakeWorld, make_scenario
from hotlap import tuners
from hotlap.core.ledger import Ledger
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.tuning.candidate import Candidate
from hotlap.tuning.goal import parse_goal
from hotlap.tuning.loop import Batch, Tuning, TuningSettings, tune
from hotlap.tuning.objective import Objective
from hotlap.tuning.progress_curve import ProgressCurve

S, C = Stream.SEARCH, Stream.CONFIRMATION


def flown(*flights: tuple[Stream, float, float], first: int = 0) -> Ledger:
    """A ledger of (stream, value of all parameters, completion)."""
    streams, values, completion = (np.array(column) for column in zip(*flights, strict=True))
    shape = np.ones((len(flights), 2, 3))
    nan, zero = np.full(len(flights), np.nan), np.zeros(len(flights))
    numbers = np.arange(first, first + len(flights))
    return Ledger(numbers, streams, values[:, None, None] * shape, numbers, 10 - completion, completion, numbers, zero, zero, nan, zero > 0)


def batch(ledger: Ledger, completion: float, *, confirmed: bool = False) -> Batch:
    best, flights = Candidate(np.ones((2, 3)), 10 - completion, completion, np.nan, 1, confirmed), int(ledger.numbers[-1]) + 1
    return Batch(ledger, best, None, (), flights, flights, confirmed, {})


def follow(*batches: Batch) -> list[tuple[int, float]]:
    curve = ProgressCurve()
    for one in batches:
        curve.follow(one)
    return curve.points


def test_a_race_that_the_first_flight_solves_is_solved_from_the_first_flight_on():
    again = [(C, 1.0, 1.0)] * 4
    assert follow(batch(flown((S, 1.0, 1.0), *again), 1.0, confirmed=True)) == [(1, 1.0)]


def test_a_better_flight_in_the_middle_of_a_batch_counts_from_there_on():
    one = batch(flown((S, 1, 0.2), (S, 2, 0.1), (S, 3, 0.6), (S, 4, 0.4)), 0.6)
    other = batch(flown((S, 5, 0.5), (S, 6, 0.8), first=4), 0.8)
    assert follow(one, other) == [(1, 0.2), (3, 0.6), (6, 0.8)]


def test_a_candidate_that_fails_when_it_is_flown_again_falls_with_that_flight():
    assert follow(batch(flown((S, 1, 0.5), (S, 2, 1.0), (C, 2, 1.0), (C, 2, 0.4)), 0.8)) == [(1, 0.5), (2, 1.0), (4, 0.8)]


def test_flights_of_a_validation_have_no_part_in_it():
    assert follow(batch(flown((S, 1, 0.5), (Stream.VALIDATION, 1, 1.0)).rows(slice(1)), 0.5)) == [(1, 0.5)]
    checked = flown((S, 1, 0.5), (Stream.VALIDATION, 1, 1.0))
    ended = Batch(checked, batch(checked.rows(slice(1)), 0.5).best, None, (), 1, 1, True, {})
    assert follow(ended) == [(1, 0.5)]


def test_a_result_that_is_chosen_in_the_end_takes_the_place_of_the_last_point():
    search = batch(flown((S, 1, 0.2), (S, 2, 0.9)), 0.9)
    chosen = Batch(flown((Stream.SELECTION, 1, 0.7)), batch(flown((S, 1, 0.7)), 0.7).best, None, (), 2, 2, True, {})
    assert follow(search, chosen) == [(1, 0.2), (2, 0.7)]


@pytest.mark.parametrize("name", ["random_search:paper", "metropolis_hastings:tied", "gate_gp:default", "cma_es:log"])
def test_all_tuners_begin_with_the_flight_of_the_first_guess_and_agree_with_every_batch(name):
    scenario, curve = make_scenario(), ProgressCurve()
    settings = TuningSettings(goal=parse_goal("completion=1"), budget=40, reliability=0.0, validation=10)
    objective = Objective(scenario, FakeWorld())
    first = objective.fly(scenario.space.first_guess(2)[None], flight_seeds(settings.seed, S, 0, 1)).completion[0]
    for one in tune(objective, Tuning(tuners.build(name), scenario, settings)):
        curve.follow(one)
        assert curve.points[-1][0] <= one.flights
        assert curve.points[-1][1] == one.best.completion
    assert curve.points[0] == (1, first)
    assert [flight for flight, _ in curve.points] == sorted({flight for flight, _ in curve.points})
