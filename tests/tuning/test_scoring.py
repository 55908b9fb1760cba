"""Cost, completion and failed segment are read off recorded flights as the paper defines them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fake_world import GATES, FakeWorld, make_scenario
from hotlap.core.records import Flights
from hotlap.race.race import GateRule, JudgeSettings
from hotlap.tuning.scoring import FAR, Metric, dense_cost, score

CLOCK = JudgeSettings()


def fly(passed: list[int]) -> Flights:
    """Flights along gates 2 m apart, of which each ended beside the first gate that it missed."""
    scenario = make_scenario()
    parameters = np.tile(scenario.space.first_guess(2), (len(passed), 1, 1))
    flights = FakeWorld().fly(scenario, parameters, np.arange(len(passed)))
    gates = np.array(passed)
    complete, stop = gates == GATES, np.minimum(gates, GATES - 1)
    position = flights.gate_positions[stop] + np.array([0.0, 3.0, 4.0])
    lap_time = np.where(complete, 4.9, np.nan)
    return replace(flights, gates_passed=gates, end_time=stop + 0.5, end_position=position, lap_time=lap_time)


def test_complete_flight_costs_its_lap_time():
    scores = score(fly([GATES]), CLOCK)
    assert scores.cost.tolist() == [4.9]
    assert scores.completion.tolist() == [1.0]
    assert scores.failed_segment.tolist() == [-1]
    assert scores.complete.tolist() == [True]


@pytest.mark.parametrize("passed", range(GATES))
def test_missed_gate_costs_the_path_from_the_drone_through_all_remaining_gates(passed):
    """5 m to the missed gate, then 2 m for each later one."""
    assert score(fly([passed]), CLOCK).cost[0] == pytest.approx(passed + 0.5 + 5.0 + 2.0 * (GATES - 1 - passed))


@pytest.mark.parametrize("passed", range(GATES))
def test_released_rule_leaves_out_the_way_to_the_missed_gate(passed):
    judge = JudgeSettings(rule=GateRule.RELEASED)
    assert score(fly([passed]), judge).cost[0] == pytest.approx(passed + 0.5 + 2.0 * (GATES - 1 - passed))


def test_completion_is_the_share_of_gates_passed():
    np.testing.assert_array_equal(score(fly(list(range(GATES + 1))), CLOCK).completion, np.arange(GATES + 1) / GATES)


def test_failed_segment_is_that_of_the_first_missed_gate():
    """Gates at 1, 2 s lie in segment 0, those at 3, 4, 5 s in segment 1, which begins at 2.5 s."""
    assert score(fly(list(range(GATES + 1))), CLOCK).failed_segment.tolist() == [0, 0, 1, 1, 1, -1]


@pytest.mark.parametrize("rule", list(GateRule))
def test_gate_distance_is_what_the_rule_measures(rule):
    flights = fly([GATES, 2])
    measured = flights.clock_distance if rule is GateRule.CLOCK else flights.closest_distance
    np.testing.assert_allclose(score(flights, JudgeSettings(rule=rule)).gate_distance, measured, rtol=1e-12)


def test_the_room_of_every_opening_is_its_own_measure():
    """At the rim the miss is 0 and the dense cost log 2 a gate, whatever the size; in the middle nothing is left."""
    flights, rooms = fly([GATES]), np.linspace(0.1, 2.0, GATES)
    rule = JudgeSettings(rule=GateRule.OPENING)
    rim, middle = (replace(flights, rooms=rooms, rim_distance=values[None]) for values in (0.0 * rooms, -rooms))
    np.testing.assert_allclose(score(rim, rule).gate_miss, 0.0, atol=1e-12)
    np.testing.assert_allclose(score(rim, rule).dense, GATES * np.log(2))
    np.testing.assert_allclose(score(middle, rule).dense, 0.0, atol=1e-12)
    assert (score(middle, rule).gate_miss < -5).all()


@pytest.mark.parametrize("lost", [np.nan, np.inf, -np.inf, 1e30])
def test_position_that_is_no_number_counts_as_far_away(lost):
    flights = fly([3])
    scores = score(replace(flights, end_position=np.full((1, 3), lost)), CLOCK)
    assert scores.cost[0] == pytest.approx(3.5 + FAR + 2.0)


def test_a_gate_more_never_costs_more_when_time_is_the_metric_and_misses_are_alike():
    costs = score(fly(list(range(GATES + 1))), CLOCK).cost
    assert (np.diff(costs) < 0).all()


def test_mean_error_is_the_cost_of_complete_flights_and_carries_the_same_penalty():
    flights = fly([GATES, 3])
    time, error = score(flights, CLOCK), score(flights, CLOCK, Metric.MEAN_ERROR)
    assert error.cost[0] == flights.mean_error[0]
    assert error.cost[1] - flights.mean_error[1] == pytest.approx(time.cost[1] - flights.end_time[1])
    np.testing.assert_array_equal(time.completion, error.completion)


def test_one_gate_is_enough():
    scenario = make_scenario()
    flights = fly([0, GATES])
    single = replace(
        flights,
        gates_passed=np.array([0, 1]),
        gate_positions=scenario.race.track.gate_positions[:1],
        gate_segments=scenario.gate_segments[:1],
        end_position=np.tile([2.0, 0.0, 0.0], (2, 1)),
    )
    np.testing.assert_allclose(score(single, CLOCK).cost, [0.5 + 1.0, 4.9])


def test_a_lap_is_no_lap_time_where_an_earlier_gate_was_missed():
    """A flight that goes on after a miss may still come through the last gate."""
    flights = replace(fly([2]), lap_time=np.array([5.1]))
    scores = score(flights, CLOCK)
    assert np.isnan(scores.lap_time[0])
    assert scores.cost[0] > 5.1


def test_dense_cost_is_a_smooth_count_of_misses():
    rim = dense_cost(np.array([[1.3, 0.0, 0.0]]), 1.3)
    assert rim[0] == pytest.approx(np.log(2))
    near, far, farther = dense_cost(np.array([[0.3], [13.0], [26.0]]), 1.3)
    assert near < 1e-4
    assert farther - far == pytest.approx(8 * np.log(2), rel=1e-6)


def test_a_gate_that_was_not_reached_is_far_and_none_is_farther():
    unreached, beyond, at = dense_cost(np.array([[np.nan], [1e6], [50.0]]), 1.3)
    assert unreached == beyond == at


def test_scores_have_the_dense_cost_of_their_gates():
    scores = score(fly([2, GATES]), CLOCK)
    np.testing.assert_array_equal(scores.dense, dense_cost(scores.gate_distance, CLOCK.distance))
    assert np.isfinite(scores.dense).all()
