import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from hotlap.race.track import Track

GATES = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]


def track(**changes):
    return Track(**{"name": "t", "start": [0, 0, 0], "gates": GATES, **changes})


def test_a_gate_may_be_a_bare_position_or_a_table():
    tabled = track(gates=[GATES[0], {"position": GATES[1], "yaw": 1.57}])
    assert np.array_equal(tabled.gate_positions, GATES)
    assert [gate.yaw for gate in tabled.gates] == [None, 1.57]


def test_the_end_is_a_waypoint_but_no_gate():
    ended = track(end=[7, 8, 9])
    assert np.array_equal(ended.waypoints, [*GATES, [7, 8, 9]])
    assert np.array_equal(ended.gate_positions, GATES)
    assert np.array_equal(track().waypoints, GATES)


@given(st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1))
def test_reading_an_attitude_makes_it_a_unit_and_reading_it_again_changes_no_bit(values):
    once = track(attitude=np.array(values) / np.linalg.norm(values) * 1.05).attitude
    assert np.linalg.norm(once) == pytest.approx(1, abs=1e-12)
    assert track(attitude=once).attitude == once


def test_an_attitude_far_from_a_unit_is_refused():
    with pytest.raises(ValidationError, match=r"norm 1, this one 1\.41"):
        track(attitude=[1, 1, 0, 0])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"gates": []}, "at least 1"),
        ({"gates": [GATES[0], GATES[0]]}, r"gates\[1\]: the same point as gates\[0\]"),
        ({"start": GATES[0]}, r"gates\[0\]: the same point as start"),
        ({"end": GATES[1]}, r"end: the same point as gates\[1\]"),
        ({"end": [0, 1e6, 0]}, "end: a coordinate of 1e"),
        ({"floor": 1.0}, "floor: 1 m lies above start"),
    ],
)
def test_an_impossible_track_is_refused_with_its_key(changes, message):
    with pytest.raises(ValidationError, match=message):
        track(**changes)


def test_the_same_gate_may_come_again_later():
    assert len(track(gates=[*GATES, GATES[0]]).gates) == 3
