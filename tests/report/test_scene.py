"""A scene says what happened, up to where a flight ended."""

from __future__ import annotations

import numpy as np
import pytest

from fake_world import make_scenario
from hotlap.core.ledger import Ledger, enter
from hotlap.core.records import End
from hotlap.core.seeds import Stream
from hotlap.race.race import GateRule, JudgeSettings
from hotlap.report.history import compare, recount
from hotlap.report.scene import repeat, stage, trace
from hotlap.tuning.goal import parse_goal
from hotlap.tuning.scoring import score
from plausible_world import OPTIMUM, PlausibleWorld


def fly(scenario, world=None, spread=(1.0, 40.0), count=2):
    """Good flights and bad ones, all recorded."""
    parameters = np.repeat(np.array([np.tile(OPTIMUM * factor, (2, 1)) for factor in spread]), count, axis=0)
    return (world or PlausibleWorld()).fly(scenario, parameters, np.arange(len(parameters)), log=range(len(parameters)))


def test_a_complete_flight_is_traced_to_the_end_of_the_plan():
    scenario = make_scenario()
    flown = trace(scenario, fly(scenario), 0, "best")
    assert not flown.failed
    assert flown.times[-1] == pytest.approx(scenario.reference.duration)
    np.testing.assert_allclose(flown.error, np.linalg.norm(flown.position - scenario.reference.position_at(flown.times), axis=1))
    assert flown.ending == "all 5 gates"


@pytest.mark.parametrize(("crash", "end", "words"), [(False, End.MISSED, "missed gate"), (True, End.CRASHED, "crashed before gate")])
def test_a_failed_flight_is_traced_to_where_it_ended(crash, end, words):
    scenario = make_scenario()
    flights = fly(scenario, PlausibleWorld(crash=crash))
    flown, passed = trace(scenario, flights, 2, "first guess"), int(flights.gates_passed[2])
    assert flown.end is end
    assert flown.ending == f"{words} {passed + 1}"
    assert flown.times[-1] == pytest.approx(flown.end_time)
    assert np.isnan(flown.gate_distance[passed + 1 :]).all()


@pytest.mark.parametrize(("rule", "share"), [(GateRule.CLOCK, 1.0), (GateRule.CLOSEST, 0.5)])
def test_gates_are_measured_as_they_are_judged(rule, share):
    scenario = make_scenario(JudgeSettings(rule=rule, distance=1.3))
    flights = fly(scenario)
    flown = trace(scenario, flights, 0, "best")
    np.testing.assert_allclose(flown.gate_distance, share * flights.clock_distance[0])
    np.testing.assert_allclose(flown.seen_times, scenario.reference.gate_times)


def test_rows_that_are_no_numbers_are_left_out():
    scenario = make_scenario()
    flights = fly(scenario)
    flights.logs[0].states[100:, 7] = np.inf
    assert len(trace(scenario, flights, 0, "best").times) == 100


def test_failures_are_where_flights_ended():
    scenario = make_scenario()
    flights = fly(scenario)
    good, bad = repeat(scenario.race, flights, slice(0, 2), "best"), repeat(scenario.race, flights, slice(2, 4), "first guess")
    assert (good.flights, good.complete, len(good.failures)) == (2, 2, 0)
    assert (bad.flights, bad.complete) == (2, 0)
    np.testing.assert_array_equal(bad.failures, flights.end_position[2:])


def test_an_end_that_is_nowhere_is_not_shown():
    scenario = make_scenario()
    flights = fly(scenario)
    flights.end_position[2] = np.nan
    assert len(repeat(scenario.race, flights, slice(2, 4), "first guess").failures) == 1


def test_a_scene_knows_its_scenario():
    scene = stage(make_scenario())
    assert scene.race == "straight"
    assert len(scene.path) == scene.reference.planned_rows == 501
    assert scene.distance == 1.3


def ledger(scenario, streams):
    parameters = np.array([np.tile(OPTIMUM * factor, (2, 1)) for factor in np.geomspace(40.0, 1.0, len(streams))])
    seeds = np.arange(len(streams))
    scores = score(PlausibleWorld(noise=0.1).fly(scenario, parameters, seeds), scenario.race.judge)
    rows = [enter(i, stream, parameters[i : i + 1], seeds[i : i + 1], scores.rows(slice(i, i + 1))) for i, stream in enumerate(streams)]
    return Ledger.join(rows)


def test_a_history_counts_from_one_and_leaves_the_validation_out():
    flown = ledger(make_scenario(), [Stream.SEARCH, Stream.SEARCH, Stream.CONFIRMATION, Stream.VALIDATION])
    history = recount(flown, parse_goal("completion=1"), "cost [s]")
    np.testing.assert_array_equal(history.numbers, [1, 2, 3])
    np.testing.assert_array_equal(history.searching, [True, True, False])
    np.testing.assert_array_equal(history.failed, flown.completion[:3] < 1)


def test_the_best_so_far_only_improves_and_knows_no_re_flights():
    flown = ledger(make_scenario(), [Stream.CONFIRMATION, *[Stream.SEARCH] * 6, Stream.CONFIRMATION])
    history = recount(flown, parse_goal("none"), "cost [s]")
    assert np.isnan(history.best_cost[0])
    assert (np.diff(history.best_cost[1:]) <= 0).all()
    assert (np.diff(history.best_completion[1:]) >= 0).all()
    assert history.best_cost[-1] == history.best_cost[-2] == history.cost[history.searching].min()


def test_the_flights_of_the_parameters_that_are_kept_are_known():
    flown = ledger(make_scenario(), [*[Stream.SEARCH] * 3, Stream.CONFIRMATION])
    assert recount(flown, parse_goal("none"), "cost [s]", flown.parameters[1]).tuned.tolist() == [False, True, False, False]
    assert not recount(flown, parse_goal("none"), "cost [s]").tuned.any(), "before there are any"


@pytest.mark.parametrize("goal", ["completion=0.5", "mean_error<0.4", "max_error<1", "none"])
def test_what_failed_is_what_missed_the_goal(goal):
    flown = ledger(make_scenario(), [Stream.SEARCH] * 8)
    complete = flown.completion >= 1
    expected = {
        "completion=0.5": flown.completion >= 0.5,
        "mean_error<0.4": complete & (flown.mean_error < 0.4),
        "max_error<1": complete & (flown.max_error < 1),
        "none": complete,
    }[goal]
    np.testing.assert_array_equal(recount(flown, parse_goal(goal), "cost [s]").failed, ~expected)


def test_a_change_names_the_unit_of_the_horizon():
    scenario = make_scenario()
    guess = scenario.space.first_guess(2)
    change = compare(scenario.space, scenario.segments, guess, guess * 0.9, 0.5)
    assert change.units == ("", "", "", "", "0.5 s")
    assert len(change.names) == change.before.shape[1]


def test_a_flight_that_flew_on_after_a_miss_has_failed():
    scenario = make_scenario()
    flights = fly(scenario)
    flights.end[2:] = int(End.FINISHED)
    assert trace(scenario, flights, 2, "first guess").ending == f"missed gate {flights.gates_passed[2] + 1}"
    assert repeat(scenario.race, flights, slice(2, 4), "first guess").complete == 0
