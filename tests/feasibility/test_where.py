"""Where most flights fail."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flight.scenarios import GATE_TIMES, fly, make_scenario
from hotlap.core.records import End
from hotlap.feasibility.where import where_most_fail

SCENARIO = make_scenario()
FLOWN = replace(
    fly(SCENARIO, 5),
    gates_passed=np.array([2, 2, 5, 1, 2]),
    end=np.array([End.MISSED, End.CRASHED, End.FINISHED, End.MISSED, End.MISSED]),
    end_time=np.array([4.2, 2.0, 3.4, 3.6, 4.2]),
)


def where(failed, flown=FLOWN):
    return where_most_fail(SCENARIO.race, flown, np.array(failed, dtype=bool))


def test_it_is_the_gate_that_most_of_those_that_failed_did_not_pass():
    found = where([1, 1, 0, 1, 1])
    assert (found.gate, found.name) == (2, "gate 3")
    assert found.flights.tolist() == [True, True, False, False, True]
    assert where([0, 0, 0, 1, 0]).name == "gate 2"


def test_a_gate_that_is_missed_is_over_at_its_time_however_late_the_judge_says_so():
    found = where([1, 1, 0, 1, 1])
    assert found.time == GATE_TIMES[2]
    assert found.times[0] < 4.2


def test_where_most_crash_before_the_gate_it_is_when_they_do():
    assert where([0, 1, 0, 0, 0]).time == 2.0


def test_flights_that_pass_all_gates_have_flown_all_of_it():
    found = where([0, 0, 1, 0, 0])
    assert found.name == ""
    assert found.time == float("inf")
    reference = SCENARIO.reference
    assert found.top_speed(reference) == reference.max_speed


def test_the_top_speed_is_that_of_what_was_flown():
    reference, found = SCENARIO.reference, where([1, 1, 0, 1, 1])
    assert found.top_speed(reference) < reference.max_speed
    speeds = np.linalg.norm(reference.velocity, axis=1)[reference.times <= GATE_TIMES[2]]
    assert found.top_speed(reference) == speeds.max()
