"""The loop asks, flies, confirms and tells by the book, and knows when to stop."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from functools import reduce
from itertools import islice, pairwise
from typing import Any

import numpy as np
import pytest

from fake_world import OPTIMUM, FakeWorld, make_scenario
from hotlap import tuners
from hotlap.core.errors import InputError
from hotlap.core.ledger import Ledger
from hotlap.core.records import Scores
from hotlap.core.seeds import FLIGHTS_A_STREAM, FORMER, Stream, flight_seeds
from hotlap.core.success_rate import Validation
from hotlap.study.increments import increment
from hotlap.tuners import Tuner
from hotlap.tuning.goal import Goal, Quantity, parse_goal
from hotlap.tuning.loop import Batch, Tuning, TuningSettings, scenario_for, tune, tune_together
from hotlap.tuning.objective import Objective

SCENARIO = make_scenario()
ALGORITHMS = tuple(dict.fromkeys(tuners.build(name.partition(":")[0]).name for name in tuners.names()))  # each with its first preset
EVERY = pytest.mark.parametrize("name", ALGORITHMS)


class Listener:
    """A tuner that hands out a list and writes down the scores that are reported to it."""

    name = "listener"
    settings = None

    def __init__(self, asked: np.ndarray) -> None:
        self.asked, self.reported = list(asked), []

    def start(self, first_guess, space, rng) -> None:
        pass

    def ask(self, n: int) -> np.ndarray:
        return np.array([self.asked.pop(0) for _ in range(min(n, len(self.asked)))])

    def tell(self, parameters: np.ndarray, scores: Scores) -> np.ndarray:
        self.reported.append(scores)
        return np.arange(len(parameters)) == 0

    def state(self) -> dict[str, Any]:
        return {}

    def restore(self, state: dict[str, Any]) -> None:
        pass


class ScriptedObjective(Objective):
    """Flights whose completions are read off a list, in the order flown; the cost of a flight is 100 (1 - completion).

    Of re-flights that are flown together, those after the first failure are not on the list: they are discarded.
    """

    def __init__(self, *completions: float) -> None:
        super().__init__(SCENARIO, FakeWorld())
        self.completions = list(completions)

    def fly(self, parameters, seeds) -> Scores:  # noqa: ARG002  it returns what it was told to
        completion, again = np.zeros(len(seeds)), seeds // FLIGHTS_A_STREAM % FORMER == Stream.CONFIRMATION
        for k in range(len(seeds)):
            if not (again[k] and k and again[k - 1] and completion[k - 1] < 1):
                completion[k] = self.completions.pop(0)
        failed = np.where(completion == 1, -1, np.round(completion * 10).astype(int))
        lap_time, dense = np.where(completion == 1, 5.0, np.nan), 10 * (1 - completion)
        flown = Scores.of_costs(100 * (1 - completion))
        miss = np.where([True, False, False], -completion[:, None], np.nan)  # of three gates, the second one ...
        miss[:, 1] = np.where(completion > 0.5, completion, np.nan)  # ... within reach of the better flights, the third of none
        return replace(flown, completion=completion, failed_segment=failed, lap_time=lap_time, dense=dense, gate_miss=miss)


def points(count: int) -> np.ndarray:
    return np.tile(SCENARIO.space.first_guess(2), (count, 1, 1)) + 0.25 * np.arange(count)[:, None, None]


def run(tuner: Tuner, objective: Objective | None = None, **settings) -> tuple[Tuning, list[Batch]]:
    tuning = Tuning(tuner, SCENARIO, TuningSettings(**{"validation": 0, **settings}))
    return tuning, list(tune(objective or Objective(SCENARIO, FakeWorld()), tuning))


def ledger_of(batches: list[Batch]) -> Ledger:
    return Ledger.join([batch.ledger for batch in batches])


def assert_same(one: Ledger, other: Ledger) -> None:
    for name, values in vars(one).items():
        np.testing.assert_array_equal(values, getattr(other, name), err_msg=name)


def test_a_candidate_is_confirmed_by_four_fresh_flights_and_ends_the_search():
    tuning, batches = run(Listener(points(5)), ScriptedObjective(0.2, 0.4, 1.0, 1.0, 1.0, 1.0, 1.0), batch=1)
    assert (tuning.flights, tuning.search_flights, tuning.done) == (7, 3, True)
    best = batches[-1].best
    assert (best.confirmed, best.completion, best.cost, best.lap_time, best.flights) == (True, 1.0, 0.0, 5.0, 5)
    np.testing.assert_array_equal(best.parameters, points(5)[2])
    assert [batch.done for batch in batches] == [False, False, True]


def test_the_first_failure_ends_a_confirmation_and_search_goes_on():
    objective = ScriptedObjective(1.0, 1.0, 0.4, 0.2, 1.0, 1.0, 1.0, 1.0, 1.0)
    tuning, batches = run(Listener(points(5)), objective, batch=1)
    assert objective.completions == []
    assert [len(batch.ledger) for batch in batches] == [3, 1, 5]
    assert (tuning.flights, tuning.search_flights) == (9, 3)


def test_the_reported_score_is_the_mean_cost_of_a_failed_candidate_and_the_flight_that_failed():
    tuner = Listener(points(2))
    run(tuner, ScriptedObjective(1.0, 1.0, 0.4, 0.2), batch=1, budget=4)
    assert tuner.reported[0].cost.tolist() == [pytest.approx((0 + 0 + 60) / 3)]
    assert tuner.reported[0].dense.tolist() == [pytest.approx((0 + 0 + 6) / 3)]
    np.testing.assert_allclose(tuner.reported[0].gate_miss, [[-(1 + 1 + 0.4) / 3, 1.0, np.nan]])
    assert tuner.reported[0].completion.tolist() == [0.4]
    assert tuner.reported[0].failed_segment.tolist() == [4]


def test_a_candidate_of_several_samples_must_succeed_in_all_of_them():
    tuner = Listener(points(3))
    flown = [1.0, 1.0, 0.4, 1.0, 1.0, 1.0, 1.0, 1.0]
    tuning, batches = run(tuner, ScriptedObjective(*flown), batch=2, samples=3, confirm=2, budget=100)
    assert (tuning.flights, tuning.search_flights, tuning.done) == (8, 6, True)
    ledger, best = batches[0].ledger, batches[0].best
    assert ledger.streams.tolist() == [Stream.SEARCH] * 6 + [Stream.CONFIRMATION] * 2
    np.testing.assert_array_equal(ledger.parameters[:6], np.repeat(points(2), 3, axis=0))
    assert len(set(ledger.seeds.tolist())) == 8
    np.testing.assert_array_equal(best.parameters, points(2)[1])
    assert (best.confirmed, best.flights) == (True, 5)
    assert tuner.reported[0].cost.tolist() == pytest.approx([20, 0])
    assert tuner.reported[0].failed_segment.tolist() == [4, -1]


def test_a_candidate_that_the_budget_cannot_fly_in_all_samples_is_not_flown():
    tuning, _ = run(Listener(points(5)), ScriptedObjective(*[0.2] * 9), batch=1, samples=3, budget=11)
    assert (tuning.flights, tuning.done) == (9, True)


def test_candidates_of_one_batch_are_confirmed_in_order_until_one_passes():
    tuner = Listener(points(4))
    objective = ScriptedObjective(0.2, 1.0, 1.0, 1.0, *(0.4,), *(1.0,) * 4)
    tuning, (batch,) = run(tuner, objective, batch=4)
    assert objective.completions == []
    assert (tuning.flights, tuning.search_flights) == (9, 3)
    np.testing.assert_array_equal(batch.best.parameters, points(4)[2])
    assert tuner.reported[0].cost.tolist() == pytest.approx([80.0, 30.0, 0.0, 0.0])


def test_reflights_count_in_the_budget_even_in_the_middle_of_a_confirmation():
    tuning, batches = run(Listener(points(9)), ScriptedObjective(0.2, 1.0, 1.0, 1.0), batch=1, budget=4)
    assert (tuning.flights, tuning.search_flights, tuning.done) == (4, 2, True)
    assert not batches[-1].best.confirmed


class OneByOne(Tuning):
    """Confirms by one flight at a time, as a person would."""

    def _confirm(self, parameters, flown):
        ledgers = []
        while not self._is_confirmed(flown) and self.settings.goal.met(flown).all() and self.flights < self.settings.budget:
            ledger, scores = yield from self._fly(Stream.CONFIRMATION, parameters[None])
            ledgers.append(ledger)
            flown = Scores.join([flown, scores])
        return flown, ledgers


@pytest.mark.parametrize(
    "changes", [{}, {"confirm": 10}, {"budget": 17}, {"samples": 3}, {"batch": 1}, {"reliability": 0.5}, {"confirm": 0}]
)
@pytest.mark.parametrize("seed", range(3))
def test_reflights_in_one_batch_are_those_that_would_be_flown_one_by_one(changes, seed):
    asked = TuningSettings(**{"seed": seed, "budget": 60, "validation": 20, "reliability": 0.999, **changes})
    flown = {}
    for way in (Tuning, OneByOne):
        world, tuning = FakeWorld(noise=0.6), way(tuners.build("metropolis_hastings"), SCENARIO, asked, np.tile(1.1 * OPTIMUM, (2, 1)))
        flown[way] = world, list(tune(Objective(SCENARIO, world), tuning))
    (together, batches), (apart, ones) = flown.values()
    assert_same(ledger_of(batches), ledger_of(ones))
    assert [batch.state for batch in batches] == [batch.state for batch in ones]
    assert [vars(batch) | {"ledger": 0, "best": 0} for batch in batches] == [vars(batch) | {"ledger": 0, "best": 0} for batch in ones]
    assert batches[-1].flights <= asked.budget
    assert sum(apart.batches) == len(ledger_of(ones))
    assert len(together.batches) <= len(apart.batches)


def test_reflights_share_a_batch_and_never_exceed_the_budget():
    for budget, batches in ((200, [1, 4]), (4, [1, 3])):
        world, settings = FakeWorld(noise=0.0), TuningSettings(budget=budget, validation=0, batch=1)
        for batch in tune(Objective(SCENARIO, world), Tuning(tuners.build("random_search"), SCENARIO, settings, np.tile(OPTIMUM, (2, 1)))):
            assert batch.done
        assert world.batches == batches


def test_without_confirmations_the_first_success_is_confirmed():
    tuning, _ = run(Listener(points(9)), ScriptedObjective(0.2, 1.0), batch=1, confirm=0)
    assert (tuning.flights, tuning.best is not None and tuning.best.confirmed) == (2, True)


def test_a_confirmed_candidate_is_validated_with_noise_of_its_own_outside_the_budget():
    objective = ScriptedObjective(0.2, *(1.0,) * 5, *(1.0, 1.0, 1.0, 1.0, 0.5))
    tuning, batches = run(Listener(points(9)), objective, batch=1, budget=6, validation=5, reliability=0.8)
    assert objective.completions == []
    assert (tuning.flights, tuning.validation_flights, tuning.done) == (6, 5, True)
    assert tuning.validation == batches[-1].validation == Validation(5, 4)
    validated = batches[-1].ledger.of(Stream.VALIDATION)
    np.testing.assert_array_equal(validated.seeds, flight_seeds(0, Stream.VALIDATION, 0, 5))
    np.testing.assert_array_equal(validated.parameters, points(9)[[1] * 5])


def test_a_candidate_that_fails_its_validation_is_reported_with_all_its_flights_and_the_search_goes_on():
    tuner = Listener(points(9))
    objective = ScriptedObjective(*(1.0,) * 5, *(1.0, 0.6, 0.2, 1.0), 0.3, *(1.0,) * 5, *(1.0,) * 4)
    tuning, batches = run(tuner, objective, batch=1, validation=4, reliability=0.75)
    assert objective.completions == []
    assert [batch.failed_validations for batch in batches] == [(Validation(4, 2),), (), ()]
    assert tuner.reported[0].cost.tolist() == [pytest.approx(120 / 9)]
    assert tuner.reported[0].completion.tolist() == [0.2]
    assert (tuning.flights, tuning.search_flights, tuning.validation_flights) == (11, 3, 8)
    np.testing.assert_array_equal(batches[-1].best.parameters, points(9)[2])
    ledger = ledger_of(batches).of(Stream.VALIDATION)
    assert ledger.numbers.tolist() == list(range(8))
    assert len(np.unique(ledger.seeds)) == 8


def test_of_candidates_that_failed_their_validation_the_most_reliable_is_the_result():
    first, second = (*(1.0,) * 5, 1.0, 1.0, 0.0, 0.0), (*(1.0,) * 5, 1.0, 0.9, 0.9, 0.9)
    tuning, _ = run(Listener(points(9)), ScriptedObjective(*first, *second, 0.95, *(1.0,) * 4), batch=1, budget=11, validation=4)
    assert tuning.best is not None
    assert (tuning.best.confirmed, tuning.best.validation_rate) == (False, 0.5)
    np.testing.assert_array_equal(tuning.best.parameters, points(9)[0])
    assert tuning.validation == Validation(4, 4)


def test_without_reliability_any_confirmed_candidate_is_taken():
    tuning, _ = run(Listener(points(9)), ScriptedObjective(*(1.0,) * 5, *(0.0,) * 3), batch=1, validation=3, reliability=0.0)
    assert (tuning.done, tuning.validation) == (True, Validation(3, 0))
    assert tuning.best is not None
    assert tuning.best.confirmed


def test_when_the_budget_is_spent_the_best_is_validated_though_it_was_not_confirmed():
    tuning, batches = run(Listener(points(9)), ScriptedObjective(0.2, 0.6, 0.4, *(1.0, 0.6)), batch=1, budget=3, validation=2)
    assert [batch.validation for batch in batches] == [None, None, None, Validation(2, 1)]
    assert [batch.done for batch in batches] == [False, False, False, True]
    np.testing.assert_array_equal(batches[-1].ledger.parameters, points(9)[[1, 1]])
    assert not batches[-1].best.confirmed
    assert tuning.flights == 3


def test_successes_of_a_validation_are_the_flights_that_meet_the_goal():
    guess = np.tile(OPTIMUM, (2, 1))
    for goal, count in (
        ("completion=1", lambda ledger: ledger.completion == 1),
        ("mean_error<0.5", lambda ledger: ledger.mean_error < 0.5),
    ):
        asked = TuningSettings(goal=parse_goal(goal), budget=1, validation=300)
        tuning = Tuning(tuners.build("metropolis_hastings"), SCENARIO, asked, guess)
        *_, last = tune(Objective(SCENARIO, FakeWorld(noise=0.9)), tuning)
        successes = int((count(last.ledger) & (last.ledger.completion == 1)).sum())
        assert 0 < successes < 300
        assert last.validation == Validation(300, successes)


def test_without_a_goal_the_budget_is_spent_and_nothing_flown_twice():
    tuning, batches = run(Listener(points(9)), ScriptedObjective(*(1.0,) * 7), goal=Goal(Quantity.NONE), batch=1, budget=7)
    assert (tuning.flights, tuning.search_flights) == (7, 7)
    assert not batches[-1].best.confirmed


def test_best_is_by_completion_then_cost_over_all_flights_of_a_candidate():
    """Three flights of four beat one of 0.9 only by their mean."""
    _, batches = run(Listener(points(9)), ScriptedObjective(0.7, 1.0, 1.0, 0.1, 0.8, 0.8), batch=1, budget=6)
    assert [round(batch.best.completion, 3) for batch in batches] == [0.7, 0.7, 0.8, 0.8]
    np.testing.assert_array_equal(batches[-1].best.parameters, points(9)[2])


def test_ledger_has_every_flight_with_its_own_score_and_the_tuners_verdict():
    _, (batch,) = run(Listener(points(2)), ScriptedObjective(1.0, 0.2, 1.0, 0.4), batch=2, budget=4)
    ledger = batch.ledger
    assert ledger.numbers.tolist() == [0, 1, 2, 3]
    assert [Stream(stream).name for stream in ledger.streams] == ["SEARCH", "SEARCH", "CONFIRMATION", "CONFIRMATION"]
    assert ledger.completion.tolist() == [1.0, 0.2, 1.0, 0.4]
    assert ledger.accepted.tolist() == [True, False, False, False]
    np.testing.assert_array_equal(ledger.parameters, points(2)[[0, 1, 0, 0]])
    np.testing.assert_array_equal(ledger.of(Stream.SEARCH).seeds, flight_seeds(0, Stream.SEARCH, 0, 2))
    np.testing.assert_array_equal(ledger.of(Stream.CONFIRMATION).seeds, flight_seeds(0, Stream.CONFIRMATION, 0, 2))


@EVERY
def test_flights_are_numbered_without_gaps_and_never_share_noise(name):
    tuning, batches = run(tuners.build(name), seed=3, budget=60)
    ledger = ledger_of(batches)
    assert ledger.numbers.tolist() == list(range(tuning.flights))
    assert len(np.unique(ledger.seeds)) == tuning.flights <= 60
    assert tuning.search_flights <= (ledger.streams == Stream.SEARCH).sum()


@EVERY
def test_same_seed_same_run_and_another_seed_another(name):
    (_, one), (_, same), (_, other) = (run(tuners.build(name), seed=seed, budget=25) for seed in (1, 1, 2))
    assert_same(ledger_of(one), ledger_of(same))
    assert not np.array_equal(ledger_of(one).cost, ledger_of(other).cost)


@EVERY
def test_stopped_after_any_batch_and_resumed_equals_never_stopped(name):
    settings = TuningSettings(seed=1, budget=30, batch=3, validation=20, reliability=0.999)
    whole = list(tune(Objective(SCENARIO, FakeWorld()), Tuning(tuners.build(name), SCENARIO, settings)))
    for batches in (1, len(whole) // 2 + 1):  # stopped after each batch, and once
        resumed, flown = Tuning(tuners.build(name), SCENARIO, settings), []
        while not resumed.done:
            flown += islice(tune(Objective(SCENARIO, FakeWorld()), resumed), batches)
            resumed = Tuning(tuners.build(name), SCENARIO, settings, state=json.loads(json.dumps(flown[-1].state, allow_nan=False)))
        assert_same(ledger_of(flown), ledger_of(whole))
        assert [batch.state for batch in flown] == [batch.state for batch in whole]
        assert [(one.flights, one.search_flights) for one in flown] == [(one.flights, one.search_flights) for one in whole]
    states = [None, *(batch.state for batch in whole)]
    written = [len(json.dumps(increment(*pair))) for pair in pairwise(states)]
    assert sum(written[len(whole) // 2 :]) < 1.5 * sum(written[: -(-len(whole) // 2)]), "no history is written anew at every batch"


def _leaves(plain: Any, *path: Any) -> Iterator[tuple[Any, ...]]:
    """Where the values of plain JSON stand, but for parameters and what is the tuner's own."""
    inner = plain.items() if isinstance(plain, dict) else enumerate(plain) if isinstance(plain, list) else ()
    for key, value in inner:
        if key not in {"tuner", "parameters", "contenders"}:
            yield from _leaves(value, *path, key)
    if not isinstance(plain, dict | list):
        yield path


@pytest.mark.parametrize("odd", [[], {}, "3", "x", -1.5])
def test_a_state_whose_counts_are_none_is_refused_when_it_is_restored(odd):
    tuner, settings = "metropolis_hastings", TuningSettings(seed=1, budget=30, validation=20, reliability=0.999, selection=20)
    *_, last = tune(Objective(SCENARIO, FakeWorld()), Tuning(tuners.build(tuner), SCENARIO, settings))
    tried = 0
    for *place, key in _leaves(last.state):
        state = json.loads(json.dumps(last.state))
        inside = reduce(lambda plain, step: plain[step], place, state)
        known, inside[key] = inside[key], odd
        if not isinstance(odd, float) or isinstance(known, int):
            tried += 1
            with pytest.raises((InputError, TypeError, KeyError)):
                Tuning(tuners.build(tuner), SCENARIO, settings, state=state)
    assert tried > 10


def test_a_run_that_has_ended_flies_no_more_after_a_restore():
    tuning, batches = run(tuners.build("metropolis_hastings"), seed=1)
    assert tuning.done
    again = Tuning(tuners.build("metropolis_hastings"), SCENARIO, TuningSettings(seed=1, validation=0), state=batches[-1].state)
    assert again.done
    assert list(tune(Objective(SCENARIO, FakeWorld()), again)) == []


@pytest.mark.check
def test_runs_in_lockstep_go_as_they_would_alone_and_share_their_batches():
    names = ALGORITHMS
    twice = [*enumerate(names), *enumerate(names)]  # two that are alike share nothing either
    together = [Tuning(tuners.build(name), SCENARIO, TuningSettings(seed=seed, budget=40, validation=0)) for seed, name in twice]
    world = FakeWorld()
    batches: list[list[Batch]] = [[] for _ in together]
    for i, batch in tune_together(Objective(SCENARIO, world), together):
        batches[i].append(batch)
    for seed, name in enumerate(names):
        _, alone = run(tuners.build(name), seed=seed, budget=40)
        for one in (batches[seed], batches[seed + len(names)]):
            assert_same(ledger_of(one), ledger_of(alone))
            assert one[-1].state == alone[-1].state
    assert max(world.batches) >= len(together)


def test_crashing_costs_without_number_leave_the_run_sane():
    class Broken(FakeWorld):
        def fly(self, scenario, parameters, seeds, *, vehicle_parameters=None, log=()):
            flights = super().fly(scenario, parameters, seeds, vehicle_parameters=vehicle_parameters, log=log)
            return replace(flights, gates_passed=np.zeros_like(flights.gates_passed), end_time=np.full(len(seeds), np.nan))

    for name in ALGORITHMS:
        _, batches = run(tuners.build(name), Objective(SCENARIO, Broken()), budget=20)
        assert batches[-1].best.cost == np.inf
        json.dumps(batches[-1].state, allow_nan=False)


def test_first_guess_is_flown_first():
    guess = np.tile(OPTIMUM, (2, 1))
    tuning = Tuning(tuners.build("metropolis_hastings"), SCENARIO, TuningSettings(), guess)
    batch = next(tune(Objective(SCENARIO, FakeWorld()), tuning))
    np.testing.assert_array_equal(batch.ledger.parameters[0], guess)
    assert batch.best.confirmed
    assert batch.validation is not None


def test_an_error_goal_is_reached_and_meant():
    goal = parse_goal("mean_error<0.6")
    objective = Objective(SCENARIO, FakeWorld(noise=0.05), goal.metric)
    tuning, _ = run(tuners.build("metropolis_hastings"), objective, goal=goal, budget=500)
    assert tuning.best is not None
    assert tuning.best.confirmed
    assert tuning.best.cost < 0.6


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("budget", 0),
        ("seed", -1),
        ("seed", 2**31),
        ("confirm", -1),
        ("batch", 0),
        ("validation", -1),
        ("reliability", 1.1),
        ("reliability", np.nan),
    ],
)
def test_settings_out_of_range_are_refused_by_name(name, value):
    with pytest.raises(InputError, match=f"^{name}: must be from"):
        TuningSettings(**{name: value})


def test_a_tuner_of_dense_costs_flies_on_after_a_miss():
    dense, sparse = tuners.build("guided_walk"), tuners.build("metropolis_hastings")
    assert scenario_for(SCENARIO, dense).race.judge.fly_on
    assert scenario_for(SCENARIO, sparse) is SCENARIO
