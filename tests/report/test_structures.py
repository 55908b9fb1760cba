"""What stands on a track is drawn as it stands: openings with their frames and directions, obstacles, box."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fake_world import make_scenario
from hall import BACKWARD, BALL, EITHER, FLAT, GATES, HALL, POINT, SQUARE, TRIANGLE, TUNNEL, UNCOUNTED
from hotlap.race.gate import Gate, PassingDirection
from hotlap.race.gate_plane import plane_of
from hotlap.race.obstacles import Box, Pole, Sphere
from hotlap.race.track import Track
from hotlap.report.structures import GateShape, arrow_line, bounds_of, box_lines, obstacle_lines, structures_of
from race.gates import oriented_gates

DISTANCE = 1.3


def shape(gate: Gate) -> GateShape:
    return GateShape(gate, plane_of(gate, DISTANCE), gate.radius or DISTANCE)


def test_gates_of_all_laps_are_drawn_once():
    known = structures_of(HALL, DISTANCE)
    assert len(known.gates) == 2 * (len(GATES) - 1)
    assert {one.gate for one in known.distinct} == set(GATES)
    assert len(known.distinct) == len(GATES)


def test_points_that_do_not_count_are_no_gates_and_the_end_is_not_drawn():
    known = structures_of(HALL.model_copy(update={"end": (1.0, 1.0, 1.0)}), DISTANCE)
    assert {point.gate for point in known.points} == {UNCOUNTED}
    assert all(gate.counts for gate in known.gates)


def test_a_track_of_bare_points_is_plain_whatever_its_floor():
    track = make_scenario().race.track.model_copy(update={"floor": 0.0})
    known = structures_of(track, DISTANCE)
    assert known.plain
    assert known.floor is None
    for change in ({"box": HALL.box}, {"ceiling": 9.0}, {"poles": HALL.poles}, {"gates": (*track.gates, BALL)}):
        assert not structures_of(track.model_copy(update=change), DISTANCE).plain


@given(oriented_gates)
def test_an_arrow_points_in_the_way_in_which_a_gate_is_passed(gate):
    arrow = shape(gate).arrow(0.7)
    if gate.direction is PassingDirection.EITHER:
        assert arrow is None
        return
    sign = -1 if gate.direction is PassingDirection.BACKWARD else 1
    np.testing.assert_allclose(arrow[1] - arrow[0], 0.7 * sign * gate.rotation[:, 0], atol=1e-9)


def test_an_arrow_of_a_tunnel_begins_at_its_end():
    tail, _ = shape(TUNNEL).arrow(1.0)
    assert np.linalg.norm(tail - TUNNEL.position) == pytest.approx(TUNNEL.depth / 2)


@given(oriented_gates)
def test_a_rim_lies_in_the_plane_of_its_gate_and_is_closed(gate):
    plane, (rim,) = plane_of(gate, DISTANCE), shape(gate).rims
    along = plane.to_gate(rim)
    np.testing.assert_allclose(along[:, 0], 0, atol=1e-9)
    np.testing.assert_allclose(plane.rim_distance(along[:, 1:]), 0, atol=1e-9)
    np.testing.assert_array_equal(rim[0], rim[-1])


@pytest.mark.parametrize("gate", [SQUARE, TRIANGLE, BACKWARD, EITHER])
def test_a_frame_lies_around_its_opening(gate):
    (frame,) = shape(gate).frames
    plane = plane_of(gate, DISTANCE)
    np.testing.assert_allclose(plane.rim_distance(plane.to_gate(frame)[:, 1:]), gate.frame, atol=1e-9)


def test_a_tunnel_has_two_ends_and_walls_between_them():
    tunnel = shape(TUNNEL)
    (first, last), normal = tunnel.rims, tunnel.plane.normal
    np.testing.assert_allclose(last - first, np.tile(TUNNEL.depth * normal, (5, 1)), atol=1e-12)
    assert len(tunnel.walls) == 4
    for wall in tunnel.walls:
        np.testing.assert_allclose(wall[1] - wall[0], TUNNEL.depth * normal, atol=1e-12)
    assert shape(SQUARE).walls == shape(FLAT).frames == ()


@given(oriented_gates, st.floats(0.01, 50.0))
def test_a_gate_is_made_larger_but_never_smaller_about_the_same_centre(gate, least):
    own = shape(gate)
    grown = own.larger(least)
    assert grown.reach == pytest.approx(max(own.reach, least))
    np.testing.assert_allclose(
        np.array(grown.rims) - own.centre, grown.reach / own.reach * (np.array(own.rims) - own.centre), atol=1e-9 * grown.reach
    )


def test_a_bare_point_keeps_the_circle_within_which_it_is_passed():
    assert shape(POINT).larger(9.0).radius == DISTANCE
    assert shape(BALL).larger(9.0).radius == 9.0


def around(**changes) -> tuple[np.ndarray, np.ndarray]:
    """What has to be seen of a track from (0, 0, 0) to (10, 0, 0)."""
    track = Track.model_validate({"name": "line", "start": (0.0, 0.0, 0.0), "gates": [[10.0, 0.0, 0.0]], **changes})
    return structures_of(track, DISTANCE).surround(np.zeros(3), np.array([10.0, 0.0, 0.0]))


def test_obstacles_near_the_track_are_in_the_drawing_and_those_far_away_do_not_make_it_small():
    low, high = around(spheres=[{"position": (5.0, 4.0, 0.0), "radius": 1.0}, {"position": (500.0, 0.0, 0.0), "radius": 1.0}])
    np.testing.assert_allclose([low, high], [[0, 0, -1], [10, 5, 1]])


def test_an_endless_pole_does_not_make_a_drawing_endless():
    low, high = around(poles=[{"position": (5.0, 0.0), "radius": 0.5}])
    np.testing.assert_allclose([low, high], [[0, -0.5, 0], [10, 0.5, 0]])


def test_the_box_is_in_the_drawing_where_it_fits():
    low, high = around(box={"low": (-3.0, -2.0, -900.0), "high": (800.0, 2.0, 3.0)}, floor=-2.5, ceiling=2.5)
    np.testing.assert_allclose([low, high], [[-3, -2, -2.5], [10, 2, 3]])


@pytest.mark.parametrize("obstacle", [*HALL.spheres, *HALL.boxes, HALL.poles[0]])
def test_the_lines_of_an_obstacle_reach_its_bounds(obstacle):
    lines = np.vstack(obstacle_lines(obstacle, np.full(3, -50.0), np.full(3, 50.0)))
    np.testing.assert_allclose([lines.min(axis=0), lines.max(axis=0)], bounds_of(obstacle))


def test_a_pole_stands_on_the_floor_and_ends_with_the_drawing():
    pole = Pole(position=(1.0, 2.0), radius=0.1)
    standing = structures_of(HALL.model_copy(update={"poles": (pole,)}), DISTANCE).obstacles[0]
    heights = np.vstack(obstacle_lines(standing, np.full(3, -5.0), np.full(3, 6.0)))[:, 2]
    assert (heights.min(), heights.max()) == (HALL.floor, 6.0)


def test_a_box_has_twelve_edges_along_the_axes():
    edges = np.array(box_lines(Box(low=(0.0, 0.0, 0.0), high=(1.0, 2.0, 3.0))))
    lengths = np.abs(edges[:, 1] - edges[:, 0])
    assert sorted(lengths.sum(axis=1)) == [1.0] * 4 + [2.0] * 4 + [3.0] * 4
    assert len(np.unique(edges.reshape(12, 6), axis=0)) == 12


def test_an_arrow_has_two_barbs_behind_its_tip():
    tail, tip, left, again, right = arrow_line(np.array([[0.0, 0.0], [2.0, 0.0]]))
    np.testing.assert_array_equal([tail, tip, again], [[0, 0], [2, 0], [2, 0]])
    assert left[0] == right[0] < 2
    assert left[1] == -right[1] != 0


def test_bounds_of_an_obstacle_are_its_own():
    np.testing.assert_array_equal(bounds_of(Sphere(position=(1.0, 2.0, 3.0), radius=0.5)), [[0.5, 1.5, 2.5], [1.5, 2.5, 3.5]])
    assert not np.isfinite(bounds_of(Pole(position=(0.0, 0.0), radius=1.0))).all()
