"""The gates of a level of AirSim become a track; the numbers were worked out by hand."""

from __future__ import annotations

import math
import socket

import numpy as np
import pytest

from hotlap.core.errors import InputError
from hotlap.files.descriptions import load_quadrotor, load_track
from hotlap.importers import read
from worlds.airsim_plant import Plant
from worlds.airsim_server import Server

HALF = math.sqrt(0.5)
NORTH = [HALF, 0.0, 0.0, -HALF]  # turns the gate's y axis, to the right, to the front
SCENE = {
    "Gate10_2": ([20.0, 5.0, -2.0], [1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
    "Gate1_7": ([8.0, 0.0, -3.0], NORTH, [1.5, 1.0, 1.0]),
    "GateArch": ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
    "Gate0": ([3.0, 0.0, -2.0], NORTH, [1.0, 1.0, 1.0]),
}


def served(**options) -> Server:
    return Server(Plant(load_quadrotor("airsim"), delayed=False), **{"scene": SCENE, "racing_lab": True, **options})


def level(name=None, **options):
    with served(**options) as server:
        imported = read(f"airsim://127.0.0.1:{server.port}", name)
        assert server.violations == []
        return imported


def test_gates_are_ordered_by_their_numbers_and_turned_into_our_frame():
    gates = level().description.gates
    np.testing.assert_allclose([gate.position for gate in gates], [[3, 0, 2], [8, 0, 3], [20, -5, 2]])
    np.testing.assert_allclose([gate.rotation[:, 0] for gate in gates], [[1, 0, 0], [1, 0, 0], [0, -1, 0]], atol=1e-9)
    np.testing.assert_allclose([gate.rotation[:, 2] for gate in gates], np.tile([0, 0, 1], (3, 1)), atol=1e-9)


def test_openings_and_frames_are_those_of_drone_racing_lab_by_each_gates_scale():
    gates = level().description.gates
    np.testing.assert_allclose([(gate.width, gate.height) for gate in gates], [(1.6, 1.6), (2.4, 1.6), (1.6, 1.6)])
    np.testing.assert_allclose([gate.frame for gate in gates], [0.8 / 3, 0.4, 0.8 / 3])
    scene = {name: (*pose, [2.0, 2.0, 2.0]) for name, (*pose, _) in SCENE.items()}
    track = level(scene=scene).description
    assert (track.opening.width, track.gates[0].width) == (3.2, None)


def test_what_was_assumed_is_said():
    imported = level()
    said = " ".join(imported.taken)
    assert "the order is that of the numbers: Gate0, Gate1_7, Gate10_2" in said
    assert "a gate is passed along its y axis" in said
    assert imported.lost == ("GateArch: has no number, so its place in the order is not known",)
    assert imported.description.start == (0.0, 0.0, 1.0)
    assert "1 m above the ground" in said


def test_a_gate_that_is_passed_against_the_course_is_named():
    scene = SCENE | {"Gate1_7": ([8.0, 0.0, -3.0], [HALF, 0.0, 0.0, HALF], [1.0, 1.0, 1.0])}
    assert any(line.endswith("look at their yaw: Gate1_7") for line in level(scene=scene).taken)


def test_coordinates_are_those_that_the_vehicle_flies_in():
    """The level's begin elsewhere when settings.json sets the vehicle up at (1, 2, -0.5)."""
    imported = level(spawn=(1.0, 2.0, -0.5))
    np.testing.assert_allclose([gate.position for gate in imported.description.gates], [[2, 2, 1.5], [7, 2, 2.5], [19, -3, 1.5]])
    assert "coordinates are the vehicle's, which begin at (1.00, -2.00, 0.50) m of the level" in imported.taken


@pytest.mark.parametrize("cosys", [False, True])
def test_in_airsim_itself_gates_are_passed_along_the_axis_that_fits_the_course_and_have_no_size(cosys):
    scene = {name: ([*place], [HALF, 0.0, 0.0, HALF], scale) for name, (place, _, scale) in SCENE.items()}  # x axis to the right
    imported = level(scene=scene, racing_lab=False, cosys=cosys)
    np.testing.assert_allclose([gate.position for gate in imported.description.gates], [[3, 0, 2], [8, 0, 3], [20, -5, 2]])
    np.testing.assert_allclose([gate.rotation[0, 0] for gate in imported.description.gates], 1.0, atol=1e-9)
    assert "its y axis, which fits the course better" in " ".join(imported.taken)
    assert imported.lost[0].startswith("opening: AirSim does not say how large a gate is")
    assert imported.description.opening is None


def test_a_pose_that_is_nan_now_and_then_is_asked_for_again():
    asked = []

    def sometimes(pose):
        asked.append(pose)
        return pose if len(asked) % 3 else pose | {"position": dict.fromkeys(("x_val", "y_val", "z_val"), math.nan)}

    whole = level().table["gates"]
    assert level(altered={"simGetObjectPose": sometimes}).table["gates"] == whole
    nowhere = dict.fromkeys(("x_val", "y_val", "z_val"), math.nan)
    with pytest.raises(InputError, match=r"simGetObjectPose\(Gate0\).position.x_val: must be a finite number"):
        level(altered={"simGetObjectPose": lambda pose: pose | {"position": nowhere}})


@pytest.mark.parametrize("names", [[], ["GateArch"], None, [1, 2], "Gate1", {"Gate1": None}])
def test_a_level_without_a_course_is_refused(names):
    with pytest.raises(InputError, match=r"^airsim://127\.0\.0\.1:"):
        level(altered={"simListSceneObjects": lambda _: names})


def test_an_address_without_a_simulator_is_refused():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    with pytest.raises(InputError, match="nobody listens there"):
        read(f"airsim:127.0.0.1:{port}")
    with pytest.raises(InputError, match=r"^airsim://host:0: the port must be"):
        read("airsim://host:0")


def test_the_track_is_written_with_its_origin_and_can_be_read_again(tmp_path):
    imported = level("field")
    path = tmp_path / "field.toml"
    path.write_text(imported.text, encoding="utf-8")
    assert load_track(path) == imported.description
    assert imported.description.provenance.startswith("airsim://127.0.0.1:")
    assert imported.name == "field"
