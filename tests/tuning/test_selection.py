"""What is handed over is what succeeds most often in flights of its own, and not what was lucky once."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from fake_world import OPTIMUM, FakeWorld, make_scenario
from hotlap import tuners
from hotlap.core.ledger import Ledger
from hotlap.core.records import Scores
from hotlap.core.seeds import Stream, flight_seeds
from hotlap.tuning.goal import Goal, Quantity
from hotlap.tuning.loop import Tuning, tune
from hotlap.tuning.objective import Objective
from hotlap.tuning.selection import FINALISTS, Contenders, Finalist, Selection, merit
from hotlap.tuning.settings import TuningSettings

SCENARIO = make_scenario()
GUESS = np.tile(1.1 * OPTIMUM, (2, 1))


def flown(successes: int, flights: int, dense: float = 1.0) -> Scores:
    completion = np.where(np.arange(flights) < successes, 1.0, 0.5)
    return replace(Scores.of_costs(np.full(flights, dense)), completion=completion)


def numbered(count: int) -> list[np.ndarray]:
    return [np.full((2, 3), float(i)) for i in range(count)]


def test_nineteen_of_twenty_count_more_than_one_of_one():
    often, once = Finalist(np.ones((1, 1))).flown(flown(19, 20), Goal()), Finalist(np.ones((1, 1))).flown(flown(1, 1), Goal())
    assert often.rank > once.rank
    assert merit(flown(19, 20), Goal()) > merit(flown(1, 1), Goal()) > merit(flown(0, 1), Goal())
    assert merit(flown(0, 1, dense=1.0), Goal()) > merit(flown(0, 1, dense=np.inf), Goal())
    assert merit(flown(1, 2), Goal(), 0.5) > merit(flown(2, 2), Goal())


@pytest.mark.parametrize(("count", "flights"), [(64, 3000), (64, 100), (5, 7), (1, 10), (3, 1000), (64, 1), (2, 2)])
def test_every_round_shares_out_the_same_number_of_flights_and_half_of_them_go_on(count, flights):
    selection, spent, left = Selection.begin(numbered(count), flights), 0, []
    while selection.winner is None:
        left.append(len(selection.finalists))
        here = len(selection.finalists) * selection.flights_each
        assert here <= selection.each_round or selection.flights_each == 1
        spent += here
        selection = selection.after(flown(0, here), Goal())
    assert spent <= max(flights, 1)
    assert all(after == (before + 1) // 2 for before, after in pairwise(left))
    if flights >= 36 * count:
        assert left[0] == count
        assert spent > 0.8 * flights or count == 1


def test_the_most_reliable_of_many_is_found():
    rates, rng, found = np.linspace(0.2, 0.9, 32), np.random.default_rng(0), []
    for _ in range(40):
        selection = Selection.begin(numbered(32), 1500)
        while selection.winner is None:
            wanted = np.repeat([rates[int(one.parameters[0, 0])] for one in selection.finalists], selection.flights_each)
            completion = np.where(rng.random(len(wanted)) < wanted, 1.0, 0.5)
            selection = selection.after(replace(Scores.of_costs(np.ones(len(wanted))), completion=completion), Goal())
        found.append(rates[int(selection.winner.parameters[0, 0])])
    assert np.mean(found) > 0.85
    assert np.min(found) > 0.7


def test_candidates_that_are_known_join_late_with_the_flights_that_they_have():
    known = [Finalist(np.full((2, 3), -1.0 - i)).flown(flown(180 + i, 200), Goal()) for i in range(6)]
    selection = Selection.begin(numbered(16), 500, known)
    assert json.loads(json.dumps(selection.dump())) == Selection.load(selection.dump()).dump()
    left = []
    while selection.winner is None:
        left.append(len(selection.finalists))
        wanted = np.repeat([0.95 if one.parameters[0, 0] == -6.0 else 0.5 for one in selection.finalists], selection.flights_each)
        completion = np.where(np.random.default_rng(len(left)).random(len(wanted)) < wanted, 1.0, 0.5)
        selection = selection.after(replace(Scores.of_costs(np.ones(len(wanted))), completion=completion), Goal())
    assert left == [16, 8, 8, 4, 2]
    assert selection.winner.parameters[0, 0] == -6.0
    assert selection.winner.flights > 250


def test_of_contenders_the_best_are_kept_each_once():
    contenders, merits = Contenders(), np.random.default_rng(0).permutation(300)
    for i, one in enumerate(numbered(300)):
        contenders.add(one, (0.0, float(merits[i])))
    contenders.add(numbered(300)[0], (1.0, 0.0))
    best = [int(one[0, 0]) for one in contenders.best()]
    assert best[0] == 0
    assert best[1:] == [i for i in np.argsort(-merits).tolist() if i][: FINALISTS - 1]
    again = Contenders.load(json.loads(json.dumps(contenders.dump())))
    np.testing.assert_array_equal(again.best(), contenders.best())


def play(budget: int = 40, noise: float = 1.2, state=None, most: int | None = None, name: str = "gate_gp", **settings):
    asked = TuningSettings(**{"budget": budget, "selection": 300, "validation": 50, "confirm": 10, "seed": 4, **settings})
    tuning, batches = Tuning(tuners.build(name), SCENARIO, asked, GUESS, state), []
    for batch in tune(Objective(SCENARIO, FakeWorld(noise=noise)), tuning):
        batches.append(batch)
        if len(batches) == most:
            break
    return tuning, batches


@pytest.mark.parametrize("name", ["gate_gp", "cma_es", "gate_gp:published"])
def test_a_selection_follows_a_search_without_result_and_flies_with_noise_of_its_own(name):
    tuning, batches = play(name=name)
    ledger = Ledger.join([batch.ledger for batch in batches])
    chosen = ledger.of(Stream.SELECTION)
    assert 0 < tuning.selection_flights == len(chosen) <= 300
    np.testing.assert_array_equal(chosen.seeds, flight_seeds(4, Stream.SELECTION, 0, len(chosen)))
    assert chosen.numbers.tolist() == list(range(len(chosen)))
    assert (tuning.flights, tuning.validation_flights) == (40, 50)
    mine = (chosen.parameters == tuning.best.parameters).all(axis=(1, 2))
    assert tuning.best.flights == mine.sum() > 40
    assert tuning.best.completion == pytest.approx(chosen.completion[mine].mean())
    assert tuning.validation == batches[-1].validation


def test_a_search_with_a_result_and_one_without_selection_are_as_ever():
    for settings in ({"noise": 0.0}, {"selection": 0}):
        tuning, _ = play(**settings)
        assert tuning.selection_flights == 0
        assert tuning.done
    assert [batch.ledger.seeds.tolist() for batch in play(noise=0.0)[1]] == [
        batch.ledger.seeds.tolist() for batch in play(noise=0.0, selection=0)[1]
    ]


@pytest.mark.parametrize("remembered", [True, False])
def test_a_search_that_is_given_a_selection_only_when_it_has_ended_chooses(remembered):
    state = json.loads(json.dumps(play(selection=0, name="random_search")[1][-1].state, allow_nan=False))
    if not remembered:
        state["contenders"] = []
    tuning, _ = play(state=state, name="random_search")
    assert tuning.done
    assert (200 if remembered else 1) < tuning.selection_flights <= 300
    assert tuning.best is not None
    assert tuning.validation is not None


def test_what_is_chosen_is_confirmed_where_its_validation_succeeds():
    often, never = play(noise=0.5, confirm=1000)[0], play(noise=0.5, confirm=1000, reliability=0.0)[0]
    assert often.best is not None
    assert often.best.confirmed == (often.validation is not None and often.validation.rate >= 0.9)
    assert often.best.confirmed
    assert never.best is not None
    assert not never.best.confirmed
    assert not play(noise=0.5, goal=Goal(Quantity.NONE))[0].best.confirmed


def test_a_selection_that_was_interrupted_goes_on_as_if_it_had_not_been():
    _, whole = play()
    rounds = [i for i, batch in enumerate(whole) if (batch.ledger.streams == Stream.SELECTION).any()]
    assert len(rounds) > 3
    for most in (rounds[0], rounds[0] + 1, rounds[-1], rounds[-1] + 1):
        _, before = play(most=most)
        state = json.loads(json.dumps(before[-1].state, allow_nan=False))
        tuning, after = play(state=state)
        assert [one.state for one in before + after] == [one.state for one in whole]
        assert tuning.done


def test_a_search_that_goes_on_chooses_anew_and_does_not_forget_what_it_had_chosen():
    first, batches = play()
    state = json.loads(json.dumps(batches[-1].state, allow_nan=False))
    assert not play(state=state)[1], "a finished run flies nothing"
    second, _ = play(budget=60, state=state)
    assert second.flights == 60
    assert second.selection_flights > first.selection_flights
    assert any(np.array_equal(one.parameters, first.best.parameters) for one in second._choice._known)


def test_a_selection_of_few_flights_is_one_selection():
    for flights in range(1, 8):
        tuning, _ = play(selection=flights)
        assert tuning.done
        assert 0 < tuning.selection_flights <= flights


def test_a_search_that_goes_on_during_its_selection_chooses_among_what_it_finds_then():
    _, whole = play(name="random_search")
    rounds = [i for i, batch in enumerate(whole) if (batch.ledger.streams == Stream.SELECTION).any()]
    state = json.loads(json.dumps(whole[rounds[1]].state, allow_nan=False))
    _, after = play(name="random_search", budget=80, state=state)
    ledger = Ledger.join([batch.ledger for batch in after])
    found, chosen = (ledger.parameters[ledger.streams == stream] for stream in (Stream.SEARCH, Stream.SELECTION))
    assert (chosen[:, None] == found[None]).all(axis=(2, 3)).any()


def test_a_search_that_is_ended_still_chooses_and_validates():
    asked = TuningSettings(budget=1000, selection=300, validation=50, confirm=10)
    tuning, batches = Tuning(tuners.build("gate_gp"), SCENARIO, asked, GUESS), []
    for batch in tune(Objective(SCENARIO, FakeWorld(noise=1.2)), tuning):
        batches.append(batch)
        if len(batches) == 20:
            tuning.end_search(100)
    assert batches[-1].done
    assert tuning.flights < 60
    assert 0 < tuning.selection_flights <= 100
    assert tuning.validation is not None
