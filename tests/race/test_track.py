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
        ({"gates": [GATES[0], GATES[0]]}, r"gates\[1\]: gate 2 is at the same point as gate 1"),
        ({"start": GATES[0]}, r"gates\[0\]: gate 1 is at the same point as the start"),
        ({"end": GATES[1]}, "end: the end is at the same point as gate 2"),
        ({"end": [0, 1e6, 0]}, "end: a coordinate of 1e"),
        ({"floor": 1.0}, "floor: 1 m lies above the start"),
        ({"floor": 0.0, "ceiling": 5.0}, "ceiling: 5 m lies below gate 2 at z = 6"),
        ({"floor": 0.0, "start": [1, 1, 0], "gates": [[5, 5, 0]], "ceiling": 0.0}, "ceiling: 0 m does not lie above the floor at 0 m"),
        ({"box": {"low": [-1, -1, -1], "high": [3, 3, 9]}}, "box: gate 2 lies outside"),
        ({"gates": [[47.4, 8.55, 0.0], [47.40005, 8.55, 0.0]], "start": [47.4001, 8.55, 0.0]}, "gates: the whole track is 0.00015 m long"),
        ({"gates": [{"position": GATES[0], "counts": False}]}, "gates: none of them counts"),
        ({"gates": [GATES[0]], "laps": 2}, r"gates\[0\]: gate 1 of lap 2 is at the same point as gate 1 of lap 1"),
        ({"gates": [GATES[0]], "closed": True}, r"gates\[0\]: gate 1 at the end is at the same point as gate 1"),
        ({"laps": 0}, "greater than or equal to 1"),
        ({"opening": {"side": 1.0}}, "opening: no gate has it, for none has an orientation"),
        ({"gates": [{"position": GATES[0], "yaw": 0.0, "depth": 1.0}]}, r"gates\[0\]\.depth: needs an opening"),
        ({"gates": [{"position": GATES[0], "yaw": 0.0}], "opening": {"frame": 0.1}}, r"gates\[0\]\.frame: needs an opening"),
        ({"opening": {"side": 1.0, "radius": 1.0}}, "side: the opening is given by radius already"),
    ],
)
def test_an_impossible_track_is_refused_with_its_key(changes, message):
    with pytest.raises(ValidationError, match=message):
        track(**changes)


def test_the_same_gate_may_come_again_later():
    assert len(track(gates=[*GATES, GATES[0]]).gates) == 3


class TestRoute:
    def test_laps_are_flown_one_after_the_other_and_a_closed_track_ends_at_its_first_gate(self):
        route = track(laps=2, closed=True, end=[7, 8, 9]).route
        assert [point.name for point in route] == [
            "gate 1 of lap 1",
            "gate 2 of lap 1",
            "gate 1 of lap 2",
            "gate 2 of lap 2",
            "gate 1 at the end",
            "the end",
        ]
        assert [point.key for point in route] == ["gates[0]", "gates[1]", "gates[0]", "gates[1]", "gates[0]", "end"]
        assert [point.counts for point in route] == [True] * 5 + [False]

    def test_points_that_do_not_count_are_planned_through_and_not_counted(self):
        between = track(gates=[GATES[0], {"position": [2.0, 2.0, 2.0], "counts": False}, GATES[1]])
        assert [point.name for point in between.route] == ["gate 1", "point 2", "gate 2"]
        assert np.array_equal(between.gate_positions, GATES)
        assert len(between.waypoints) == 3

    @given(st.integers(1, 5), st.booleans(), st.booleans(), st.lists(st.booleans(), min_size=2, max_size=5).filter(any))
    def test_counts_add_up(self, laps, closed, ended, counts):
        gates = [{"position": [float(i + 1), 0.0, 0.0], "counts": count} for i, count in enumerate(counts)]
        made = track(gates=gates, laps=laps, closed=closed, end=[0.0, 5.0, 0.0] if ended else None)
        assert len(made.route) == len(made.waypoints) == laps * len(gates) + closed + ended
        assert len(made.counted) == len(made.gate_positions) == laps * sum(counts) + (closed and counts[0])
        assert list(made.gate_numbers) == [int(point.name.split()[1]) for point in made.route if point.counts]
        assert len({point.name for point in made.route}) == len(made.route)

    def test_laps_are_the_same_as_gates_written_out(self):
        assert np.array_equal(track(laps=3).gate_positions, track(gates=GATES * 3).gate_positions)


def test_the_opening_of_the_track_is_that_of_every_gate_in_the_route():
    made = track(gates=[GATES[0], {"position": GATES[1], "yaw": 0.0}], opening={"side": 1.5, "frame": 0.2}, laps=2)
    assert [gate.side for gate in made.counted] == [None, 1.5, None, 1.5]
    assert [gate.side for gate in made.gates] == [None, None], "the gates stay as they are written"


@pytest.mark.parametrize(
    ("gate", "has_openings"),
    [
        ({}, False),
        ({"radius": 0.5}, True),
        ({"yaw": 0.0}, True),
        ({"pitch": 0.5}, True),
        ({"yaw": 0.0, "counts": False}, False),
    ],
)
def test_a_track_has_openings_where_more_than_a_distance_decides(gate, has_openings):
    assert track(gates=[GATES[0], {"position": GATES[1], **gate}]).has_openings is has_openings
