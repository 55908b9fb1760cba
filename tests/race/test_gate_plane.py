import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hotlap.race.gate import Gate, PassingDirection
from hotlap.race.gate_plane import GatePlane, plane_of
from race.gates import across, angles, oriented_gates, places, regular, sizes

FREE = 0.2


def plane(**keys) -> GatePlane:
    found = plane_of(Gate(position=(0.0, 0.0, 0.0), **{"yaw": 0.0, **keys}), FREE)
    assert found is not None
    return found


def naive_rim_distance(corners, point):
    """Depth below the nearest edge of a polygon around the origin, by areas of triangles."""
    depths = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        twice_area = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])
        depths.append(-twice_area / math.dist(a, b))
    return max(depths)


@given(oriented_gates)
def test_the_axes_of_a_plane_are_normal_left_and_up(drawn):
    found = plane_of(drawn, FREE)
    assert found is not None
    assert np.linalg.det(found.rotation) == pytest.approx(1)
    assert found.to_gate(found.centre + found.normal) == pytest.approx([1, 0, 0], abs=1e-9)


@given(oriented_gates, across)
def test_the_rim_distance_is_zero_on_the_rim_and_its_sign_says_inside(drawn, point):
    found = plane_of(drawn, FREE)
    assert found is not None
    rim = found.to_gate(found.outline())[:, 1:]
    assert found.rim_distance(rim) == pytest.approx(0, abs=1e-6)
    assert (found.rim_distance(0.5 * rim) < 0).all()
    assert (found.rim_distance(2.0 * rim) > 0).all()
    if len(found.corners):
        assert found.rim_distance(np.array(point)) == pytest.approx(naive_rim_distance(found.corners, point), abs=1e-9)


@given(st.integers(3, 12), sizes, angles, angles, across)
def test_a_roll_turns_the_opening_and_nothing_else(corners, radius, turned, roll, point):
    by_roll = plane(corners=regular(corners, radius, turned), roll=roll)
    by_corners = plane(corners=regular(corners, radius, turned + roll))
    world = np.array([0.0, *point])
    seen = [each.rim_distance(each.to_gate(world)[1:]) for each in (by_roll, by_corners)]
    assert seen[0] == pytest.approx(seen[1], abs=1e-9)


@given(oriented_gates, places)
def test_the_rim_distance_of_a_place_does_not_depend_on_where_and_how_the_gate_stands(drawn, place):
    here, moved = plane_of(drawn, FREE), plane_of(drawn.model_copy(update={"position": place, "yaw": 0.3, "pitch": 0.2, "roll": 0.1}), FREE)
    assert here is not None
    assert moved is not None
    local = np.array([0.4, -0.7, 0.3])
    seen = [each.to_gate(each.centre + each.rotation @ local) for each in (here, moved)]
    assert seen[0] == pytest.approx(seen[1], abs=1e-9)
    assert here.rim_distance(seen[0][1:]) == pytest.approx(moved.rim_distance(seen[1][1:]), abs=1e-9)


@given(oriented_gates, places)
def test_backward_mirrors_the_way_and_leaves_the_hole(drawn, place):
    forward, backward = (
        plane_of(drawn.model_copy(update={"direction": way}), FREE) for way in (PassingDirection.FORWARD, PassingDirection.BACKWARD)
    )
    assert forward is not None
    assert backward is not None
    assert backward.normal == pytest.approx(-forward.normal)
    assert backward.rotation[:, 2] == pytest.approx(forward.rotation[:, 2])
    there, back = forward.to_gate(np.array(place)), backward.to_gate(np.array(place))
    assert back == pytest.approx(there * [-1, -1, 1])
    assert backward.rim_distance(back[1:]) == pytest.approx(forward.rim_distance(there[1:]), abs=1e-9)


@given(oriented_gates, st.floats(0.0, 2.0))
def test_a_grown_outline_lies_that_far_outside(drawn, distance):
    found = plane_of(drawn, FREE)
    assert found is not None
    outline = found.to_gate(found.outline(grown=distance))
    assert outline[:, 0] == pytest.approx(0, abs=1e-9)
    assert found.rim_distance(outline[:, 1:]) == pytest.approx(distance, abs=1e-6)


@pytest.mark.parametrize(
    ("keys", "room"),
    [
        ({"radius": 0.7}, 0.7),
        ({"side": 1.6}, 0.8),
        ({"width": 3.0, "height": 1.0}, 0.5),
        ({"corners": regular(3, 2.0)}, 1.0),
        ({"corners": regular(6, 1.0)}, math.sqrt(3) / 2),
        ({"corners": ((2.0, -1.0), (-1.0, -1.0), (-1.0, 3.0))}, 1.0),  # sides 3, 4, 5
    ],
)
def test_the_room_of_simple_shapes_is_known(keys, room):
    assert plane(**keys).room == pytest.approx(room)


@given(st.lists(st.floats(-0.3, 0.3), min_size=3, max_size=8))
def test_the_middle_is_at_least_as_far_inside_as_any_point(shifts):
    around = 2 * math.pi * (np.arange(len(shifts)) + shifts) / len(shifts)
    found = plane(corners=tuple(zip(np.cos(around).tolist(), np.sin(around).tolist(), strict=True)))
    middle, room = found.middle
    assert found.rim_distance(middle) == pytest.approx(-room, abs=1e-6)
    tried = np.random.default_rng(0).uniform(-1, 1, (200, 2))
    assert found.rim_distance(tried).min() >= -room - 1e-6


def test_an_orientation_alone_is_a_free_circle_and_an_opening_is_solid():
    assert (plane().radius, plane().solid) == (FREE, False)
    assert (plane(radius=0.5).radius, plane(radius=0.5).solid) == (0.5, True)


def test_only_either_way_is_not_one_way():
    assert [plane(direction=way).one_way for way in ("forward", "backward", "either")] == [True, True, False]


def test_points_and_balls_have_no_plane():
    assert plane_of(Gate(position=(0.0, 0.0, 0.0)), FREE) is None
    assert plane_of(Gate(position=(0.0, 0.0, 0.0), radius=1.0), FREE) is None
