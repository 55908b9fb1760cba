"""Distances from solids are those of their surfaces, and lead away from them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.race.gate_plane import plane_of
from hotlap.race.solids import Solid, floor_at, plug, same_place, solids_of, walls_of
from hotlap.race.track import Track

TRACK = Track.model_validate(
    {
        "name": "solid",
        "start": (0.0, 0.0, 1.0),
        "gates": (
            {"position": (3.0, 0.0, 1.0), "yaw": 0.3, "side": 1.0, "frame": 0.3, "depth": 0.1},
            {"position": (6.0, 1.0, 1.0), "yaw": 0.0, "radius": 0.5, "frame": 0.2},
            {"position": (9.0, 1.0, 1.0), "yaw": 0.0, "pitch": 0.5, "corners": ((0.0, 1.0), (-1.0, -0.5), (1.0, -0.5)), "frame": 0.2},
        ),
        "poles": (
            {"position": (1.0, 2.0), "radius": 0.2},
            {"position": (2.0, 2.0), "radius": 0.1, "top": 1.5, "bottom": 0.5},
            {"position": (2.0, -2.0), "radius": 0.1, "top": 1.5},
        ),
        "spheres": ({"position": (1.0, 2.0, 1.0), "radius": 0.2},),
        "boxes": ({"low": (0.0, 0.0, 0.0), "high": (1.0, 2.0, 3.0)},),
        "ceiling": 8.0,
        "box": {"low": (-5.0, -5.0, 0.0), "high": (15.0, 6.0, 7.0)},
    }
)
SOLIDS = {f"{k} {solid.name}": solid for k, solid in enumerate((*solids_of(TRACK, 0.2), *walls_of(TRACK), floor_at(0.0)))}

each_solid = pytest.mark.parametrize("solid", SOLIDS.values(), ids=SOLIDS)


def draw(count: int = 800) -> np.ndarray:
    return np.random.default_rng(1).uniform([-1, -3, -1], [11, 4, 4], size=(count, 3))


@each_solid
def test_the_direction_is_the_slope_of_the_distance(solid: Solid):
    points, step = draw(), 1e-6
    slopes = np.stack(
        [(solid.measure(points + step * axis)[0] - solid.measure(points - step * axis)[0]) / (2 * step) for axis in np.eye(3)], axis=1
    )
    assert_allclose(slopes, solid.measure(points)[1], atol=1e-5)


@each_solid
def test_going_back_by_the_distance_ends_on_the_surface(solid: Solid):
    points = draw()
    distances, away = solid.measure(points)
    outside = distances > 0
    assert outside.any()
    assert_allclose(solid.measure((points - distances[:, None] * away)[outside])[0], 0.0, atol=1e-9)


@each_solid
def test_what_is_near_is_within_the_ball_around_a_solid(solid: Solid):
    points = draw()
    assert not (solid.measure(points)[0] < 0.3)[~solid.near(points, 0.3)].any()


@each_solid
def test_places_around_a_solid_keep_the_distance(solid: Solid):
    places = solid.around(0.3, np.array([1.0]))
    assert solid.wall == (not len(places))
    assert (solid.measure(places)[0] > 0.3).sum() >= 0.7 * len(places)


def test_distances_are_those_measured_by_hand():
    found = {solid.name: solid.measure(np.array([[1.0, 4.0, 1.0]]))[0][0] for solid in solids_of(TRACK, 0.2)}
    assert_allclose([found["pole 1"], found["sphere 1"], found["box 1"]], [1.8, 1.8, 2.0])
    assert_allclose(found["pole 2"], np.hypot(1.0, 2.0) - 0.1)
    above = {solid.name: solid.measure(np.array([[2.0, -2.0, 2.5]]))[0][0] for solid in solids_of(TRACK, 0.2)}
    assert_allclose(above["pole 3"], 1.0)


def test_the_middle_of_an_opening_is_as_far_from_its_frame_as_there_is_room():
    for gate, solid in zip(TRACK.gates, [solid for solid in solids_of(TRACK, 0.2) if solid.plane], strict=True):
        plane = plane_of(gate, 0.2)
        assert plane is not None
        middle = plane.centre + plane.rotation[:, 1:] @ plane.middle[0]
        assert_allclose(solid.measure(middle[None])[0], plane.room)


def test_gates_at_the_same_place_have_one_frame():
    there = {"position": (3.0, 0.0, 1.0), "yaw": 0.0, "side": 1.0, "frame": 0.1}
    between = {"position": (6.0, 0.0, 1.0)}
    track = Track.model_validate({"name": "back", "start": (0.0, 0.0, 1.0), "gates": (there, between, {**there, "yaw": np.pi})})
    assert [solid.name for solid in solids_of(track, 0.2)] == ["the frame of gate 1"]
    assert same_place(plane_of(track.gates[0], 0.2), plane_of(track.gates[2], 0.2))


def test_a_plug_fills_the_opening():
    plane = plane_of(TRACK.gates[0], 0.2)
    assert plane is not None
    distances = plug("gate 1", plane).measure(plane.centre + np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.6]]))[0]
    assert_allclose(distances, [-0.05, 0.1])
