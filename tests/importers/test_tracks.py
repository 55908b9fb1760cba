"""Tracks of other programs are read as they stand there; the numbers were checked by hand."""

from __future__ import annotations

from math import cos, pi, radians, sin, sqrt

import numpy as np
import pytest

from hotlap.core.errors import InputError
from hotlap.importers import read
from hotlap.importers.turning import angles_of, quaternion_of, rotation_of
from hotlap.race.gate import Gate
from hotlap.race.gate_plane import plane_of
from importers.changed import SAMPLES, changed


@pytest.fixture(scope="module")
def togt():
    return read(SAMPLES / "togt_track.yaml")


def test_gates_of_togt_are_passed_as_its_prisms_stand(togt):
    planes = [plane_of(gate, 1.0) for gate in togt.description.gates]
    normals = [plane.normal for plane in planes if plane is not None]
    np.testing.assert_allclose(normals, [[0, 1, 0], [-1, 0, 0], [0, 0, -1], [-1, 0, 0]], atol=1e-9)
    assert planes[4] is None


def test_shapes_of_togt_have_their_corners_where_togt_puts_them(togt):
    """Its corners are (up, left, 0) in a frame whose columns are up, left and against the normal."""
    _, triangle, pentagon, hexagon, _ = togt.description.gates
    r, s = 1.5, 1.2
    expected = {
        triangle: ((0, 90, 0), [(-1, 1.2), (1, 0), (-1, -1.2)]),
        pentagon: ((0, 0, 0), [(r * cos(2 * pi * k / 5), r * sin(2 * pi * k / 5)) for k in range(5)]),
        hexagon: ((0, -90, 180), [(x * s * sqrt(3) / 2, y * s / 2) for x, y in [(-1, 1), (0, 2), (1, 1), (1, -1), (0, -2), (-1, -1)]]),
    }
    for gate, (rpy, corners) in expected.items():
        rotation = rotation_of(*map(radians, rpy))
        world = [np.array(gate.position) + rotation @ [up, left, 0] for up, left in corners]
        plane = plane_of(gate, 1.0)
        assert plane is not None
        ours = plane.outline()
        assert all(np.linalg.norm(ours - corner, axis=1).min() < 1e-9 for corner in world)


def test_sizes_lengths_and_balls_of_togt_are_carried_over(togt):
    rectangle, triangle, pentagon, hexagon, ball = togt.description.gates
    assert (rectangle.width, rectangle.height) == (2.4, 2.0)
    assert (triangle.depth, pentagon.depth, hexagon.depth) == (3.0, 0.0, 0.0)
    assert (ball.radius, ball.oriented) == (0.4, False)  # 0.5 less half of the margin
    track = togt.description
    assert (track.start, track.end, track.end_at_rest) == ((0, 0, 1), (0, 12, 1), True)
    np.testing.assert_allclose(track.attitude, [sqrt(0.5), 0, 0, sqrt(0.5)])


def test_margins_of_togt_are_named_as_a_clearance_and_not_cut_away(togt):
    said = " ".join(togt.taken)
    assert "planning.clearance = 0.4 " in said  # half of the 0.8 m of width
    assert "0.1732 to 0.4 m" in said  # the hexagon's side less 0.2 m moves its edges by 0.2 cos 30 deg
    assert any(remark.startswith("Gate6: is not among the orders") for remark in togt.lost)


def test_a_level_of_lsy_has_openings_frames_poles_and_a_box():
    imported = read(SAMPLES / "lsy_level.toml")
    track = imported.description
    assert [gate.yaw for gate in track.gates] == [-0.5, 2.0]
    assert (track.gates[1].pitch, track.gates[1].roll) == (0.2, 0.1)
    assert all((gate.side, gate.frame) == (0.4, 0.16) for gate in track.counted)
    assert track.attitude == pytest.approx((sqrt(0.5), 0, 0, sqrt(0.5)))
    assert track.floor == 0.0
    pole, *stands = track.poles
    assert (pole.position, pole.radius, pole.top) == ((0.0, 0.75), 0.015, 1.5)
    assert [stand.position for stand in stands] == [(0.5, 0.25), (1.0, 1.0)]
    assert [stand.top for stand in stands] == pytest.approx([0.34, 0.84])
    assert track.box is not None
    assert track.box.high == pytest.approx((2.6, 1.6, 2.1))
    assert track.box.low == pytest.approx((-2.6, -1.6, -0.101))
    assert any("env.randomizations: gate_pos" in remark for remark in imported.lost)
    assert any("as cf21B_500" in remark for remark in imported.lost)


def test_a_level_of_lsy_in_its_older_form_starts_from_its_one_drone(tmp_path):
    older = changed("lsy_level.toml", tmp_path, ("[[env.track.drones]]", "[env.track.drone]"))
    assert read(older).description.start == (-1.5, 0.5, 0.01)


def test_a_track_that_is_drawn_anew_for_each_flight_is_refused(tmp_path):
    random = changed("lsy_level.toml", tmp_path, ("randomize = false", "randomize = true"))
    with pytest.raises(InputError, match=r"env\.track\.randomize: the gates are drawn anew"):
        read(random)


def test_a_track_of_rpg_time_optimal_has_points_a_start_and_an_end():
    track = read(SAMPLES / "rpg_track.yaml").description
    assert [gate.position for gate in track.gates] == [(-1.0, -1.5, 3.5), (9.0, 6.5, 1.0)]
    assert (track.start, track.start_velocity) == ((-5, 4.5, 1.2), (1, 0, 0))
    assert (track.end, track.end_at_rest, track.closed) == ((4.5, -1.0, 1.2), False, False)


def test_an_end_at_the_last_gate_is_that_gate(tmp_path):
    there = changed("rpg_track.yaml", tmp_path, ("position: [4.5, -1.0, 1.2]", "position: [9.0, 6.5, 1.0]\n  velocity: [0, 0, 0]"))
    track = read(there).description
    assert (track.end, track.end_at_rest) == (None, True)


def test_a_ring_of_rpg_time_optimal_is_closed(tmp_path):
    track = read(changed("rpg_track.yaml", tmp_path, ("initial:", "ring: true\ninitial:"))).description
    assert track.closed
    assert len(track.counted) == 3


def test_gates_of_fast_fly_are_turned_from_north_east_down():
    imported = read(SAMPLES / "fast_fly_gates.yaml")
    assert [gate.position for gate in imported.description.gates] == [(1, -2, 3), (8, 6, 2)]
    assert imported.description.start == (8, 6, 2)
    assert any(remark.startswith("rot: ") for remark in imported.lost)


@pytest.mark.parametrize("angles", [(0.1, 0.2, 0.3), (-2.0, 1.2, 3.0), (0.4, pi / 2, 1.0), (0.0, -pi / 2, -2.0), (pi, 0.0, pi)])
def test_the_angles_of_a_gate_turn_it_as_its_matrix_does(angles):
    rotation = rotation_of(*angles)
    gate = Gate(position=(0, 0, 0), **angles_of(rotation))  # pyright: ignore[reportArgumentType]
    np.testing.assert_allclose(gate.rotation, rotation, atol=1e-9)


def test_a_quaternion_turns_as_the_matrix_does():
    w, x, y, z = quaternion_of(0.3, -0.4, 2.0)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    np.testing.assert_allclose(np.eye(3) + 2 * w * cross + 2 * cross @ cross, rotation_of(0.3, -0.4, 2.0), atol=1e-12)
