import math

import numpy as np
import pytest
from hypothesis import given
from pydantic import ValidationError

from hotlap.core.errors import InputError
from hotlap.files.descriptions import load_track
from hotlap.race.gate import Gate, Opening, PassingDirection
from hotlap.race.track import Track
from race.gates import angles, oriented_gates, regular

HERE = (1.0, 2.0, 3.0)


def gate(**keys):
    return Gate(position=HERE, **keys)


class TestOrientation:
    def test_a_yaw_of_zero_looks_along_x_and_a_quarter_turn_along_y(self):
        assert gate(yaw=0.0).rotation == pytest.approx(np.eye(3))
        assert gate(yaw=math.pi / 2).rotation[:, 0] == pytest.approx([0, 1, 0])

    def test_a_positive_pitch_turns_the_normal_down_and_a_roll_leaves_it(self):
        assert gate(pitch=math.pi / 2).rotation[:, 0] == pytest.approx([0, 0, -1])
        assert gate(yaw=0.3, pitch=0.2, roll=0.7).rotation[:, 0] == pytest.approx(gate(yaw=0.3, pitch=0.2).rotation[:, 0])

    def test_up_is_up_and_left_is_left_without_pitch_and_roll(self):
        rotation = gate(yaw=1.0).rotation
        assert rotation[:, 2] == pytest.approx([0, 0, 1])
        assert rotation[:, 1] == pytest.approx(np.cross([0, 0, 1], rotation[:, 0]))

    @given(angles, angles, angles)
    def test_a_rotation_turns_and_mirrors_nothing(self, yaw, pitch, roll):
        rotation = gate(yaw=yaw, pitch=pitch, roll=roll).rotation
        assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-12)
        assert np.linalg.det(rotation) == pytest.approx(1)

    def test_any_angle_is_an_orientation_and_none_is_none(self):
        assert all(gate(**{key: value}).oriented for key, value in (("yaw", 0.0), ("pitch", 0.1), ("roll", 0.1)))
        assert not gate().oriented


class TestShape:
    def test_sizes_are_whole_widths_and_round_openings_have_no_corners(self):
        assert np.ptp(gate(yaw=0.0, side=1.5).polygon, axis=0) == pytest.approx([1.5, 1.5])
        assert np.ptp(gate(yaw=0.0, width=2.0, height=1.0).polygon, axis=0) == pytest.approx([2.0, 1.0])
        assert gate(yaw=0.0, radius=1.0).polygon.shape == (0, 2)

    def test_corners_run_one_way_however_they_are_written(self):
        corners = regular(5, 1.0, 0.3)
        written = {order: gate(yaw=0.0, corners=order).polygon for order in (corners, corners[::-1])}
        for polygon in written.values():
            following = np.roll(polygon, -1, axis=0)
            assert (polygon[:, 0] * following[:, 1] - polygon[:, 1] * following[:, 0] > 0).all()
        assert len({frozenset(map(tuple, polygon)) for polygon in written.values()}) == 1

    @given(oriented_gates)
    def test_a_gate_written_down_reads_back_equal(self, drawn):
        assert Gate.model_validate_json(drawn.model_dump_json()) == drawn


class TestOpeningOfTheTrack:
    def test_it_gives_what_a_gate_does_not_say(self):
        opening = Opening(side=1.5, frame=0.2)
        assert gate(yaw=0.0).completed(opening) == gate(yaw=0.0, side=1.5, frame=0.2)
        assert gate(yaw=0.0, radius=0.4).completed(opening) == gate(yaw=0.0, radius=0.4, frame=0.2)
        assert gate(yaw=0.0, depth=3.0).completed(opening) == gate(yaw=0.0, side=1.5, frame=0.2, depth=3.0)

    def test_points_and_balls_do_not_have_it(self):
        assert gate().completed(Opening(side=1.5)) == gate()
        assert gate(radius=0.3).completed(Opening(side=1.5)) == gate(radius=0.3)


def test_without_a_direction_it_is_passed_along_its_normal():
    assert gate(yaw=0.0).direction is PassingDirection.FORWARD
    assert gate(yaw=0.0, direction="either").direction is PassingDirection.EITHER


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"yaw": -90.0}, r"-90 rad is more than a full turn; angles are in radians \(did you mean -1\.571"),
        ({"yaw": 0.0, "pitch": 7.0}, "pitch\n.*more than a full turn"),
        ({"side": 1.5}, "yaw: is missing; a gate with side needs the heading"),
        ({"width": 1.5, "height": 1.0}, "yaw: is missing; a gate with width"),
        ({"corners": regular(3, 1.0)}, "yaw: is missing; a gate with corners"),
        ({"frame": 0.1}, "yaw: is missing; a gate with frame"),
        ({"radius": 1.0, "depth": 0.1}, "yaw: is missing; a gate with depth"),
        ({"direction": "backward"}, "yaw: is missing; a gate with direction"),
        ({"direction": "up"}, "'forward', 'backward' or 'either'"),
        ({"yaw": 0.0, "side": 1.0, "radius": 1.0}, "side: the opening is given by radius already"),
        ({"yaw": 0.0, "side": 1.0, "height": 1.0}, "width: the opening is given by side already"),
        ({"yaw": 0.0, "side": 1.0, "corners": regular(4, 1.0)}, "corners: the opening is given by side already"),
        ({"yaw": 0.0, "width": 1.0}, "height: is missing; a rectangular opening has width and height"),
        ({"yaw": 0.0, "height": 1.0}, "width: is missing"),
        ({"yaw": 0.0, "side": 0.0}, "greater than 0"),
        ({"yaw": 0.0, "side": 1.0, "frame": -0.1}, "greater than or equal to 0"),
        ({"yaw": 0.0, "side": 1e300}, "less than or equal to 100000"),
        ({"yaw": 0.0, "corners": regular(3, 1e200)}, r"a corner .* m from the position; corners are in metres"),
        ({"yaw": 0.0, "corners": ((0.0, 1.0), (1.0, 0.0))}, "corners\n.*a polygon has 3 to 12 corners, not 2"),
        ({"yaw": 0.0, "corners": regular(13, 1.0)}, "3 to 12 corners, not 13"),
        ({"yaw": 0.0, "corners": ((1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0))}, "not those of a convex polygon"),
        ({"yaw": 0.0, "corners": ((1.0, 1.0), (-1.0, 1.0), (0.0, 0.1), (-1.0, -1.0), (1.0, -1.0))}, "not those of a convex polygon"),
        ({"yaw": 0.0, "corners": tuple(regular(5, 1.0)[2 * k % 5] for k in range(5))}, "not those of a convex polygon"),  # a star
        ({"yaw": 0.0, "corners": ((1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0))}, "the gate's position lies outside of its corners"),
    ],
)
def test_an_impossible_gate_is_refused_with_its_key(keys, message):
    with pytest.raises(ValidationError, match=message):
        gate(**keys)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("{ position = [1, 2, 3], side = 1.5 }", "gates[0].yaw"),
        ("{ position = [1, 2, 3], yaw = 90.0 }", "gates[0].yaw"),
        ("{ position = [1, 2, 3], yaw = 1.0, width = 1.5 }", "gates[0].height"),
        ("{ position = [1, 2, 3], yaw = 1.0, corners = [[1, 0], [0, 1]] }", "gates[0].corners"),
        ("{ position = [1, 2, 3], yaw = 1.0, corners = [[1, 0], [0]] }", "gates[0].corners[1]"),
        ("{ position = [1, 2, 3], yaw = 1.0, frame = 0.1 }", "gates[0].frame"),
        ('{ position = [1, 2, 3], yaw = 1.0, direction = "up" }', "gates[0].direction"),
        ("{ position = [1, 2, 3], yaw = 1.0, size = 1.5 }", "gates[0].size"),
    ],
)
def test_a_fault_in_a_file_names_gate_and_key(text, key, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(f"start = [0, 0, 0]\ngates = [{text}]\n")
    with pytest.raises(InputError) as caught:
        load_track(path)
    assert caught.value.key == key


def test_a_ball_is_a_radius_without_orientation():
    ball = gate(radius=0.5)
    assert ball.shaped
    assert not ball.oriented
    assert Track(name="t", start=(0.0, 0.0, 0.0), gates=(ball,)).has_openings
