"""What a path meets on a track is found, with its kind, name and moment."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hotlap.race.track import Track
from hotlap.reference.encounters import EncounterKind as Kind

from .passages import MISSED, PASSED, WRONG_WAY, find_all

GATE = {"position": (4.0, 0.0, 1.0), "yaw": 0.0, "side": 1.0, "frame": 0.2}


def track(gates: Any = (GATE,), **others: Any) -> Track:
    return Track.model_validate({"name": "path", "start": (0.0, 0.0, 1.0), "gates": gates, **others})


def met(course: Track, *corners: tuple[float, float, float], radius: float = 0.1) -> list[tuple[str, str]]:
    """What a path along straight lines at 1 m/s meets."""
    points = np.array(corners)
    marks = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    times = np.arange(0.0, marks[-1], 0.003)
    path = np.stack([np.interp(times, marks, column) for column in points.T], axis=1)
    return [one[:2] for one in find_all(times, path, course, radius, 0.2)]


def test_a_straight_flight_passes_the_gate_and_meets_nothing_else():
    assert met(track(), (0, 0, 1), (8, 0, 1)) == [(PASSED, "gate 1")]


def test_a_passage_has_its_moment_and_its_distance_from_the_rim():
    times = np.linspace(0.0, 8.0, 1001)
    path = np.column_stack([times, np.full_like(times, 0.2), np.ones_like(times)])
    ((_, _, time, distance),) = find_all(times, path, track(), 0.1, 0.2)
    assert time == pytest.approx(4.0)
    assert distance == pytest.approx(-0.3)


@pytest.mark.parametrize(("aside", "passed"), [(0.39, True), (0.41, False)])
def test_the_vehicle_has_to_fit_into_the_opening_with_its_radius(aside, passed):
    course = track(({**GATE, "frame": 0.0},))
    assert met(course, (0, aside, 1), (8, aside, 1)) == [(PASSED if passed else MISSED, "gate 1")]


def test_a_frame_that_is_touched_is_named():
    assert (Kind.FRAME, "the frame of gate 1") in met(track(), (0, 0.55, 1), (8, 0.55, 1))


def test_a_gate_crossed_against_its_direction_and_then_in_it_is_both():
    found = met(track(), (0, 0, 1), (0, 2, 1), (6, 2, 1), (6, 0, 1), (2, 0, 1), (8, 0, 1))
    assert found == [(WRONG_WAY, "gate 1"), (PASSED, "gate 1")]


def test_either_way_counts_where_the_gate_says_so():
    assert met(track(({**GATE, "direction": "either"},)), (0, 0, 1), (0, 2, 1), (6, 2, 1), (6, 0, 1), (2, 0, 1)) == [(PASSED, "gate 1")]


def test_a_frame_that_is_passed_there_and_back_is_no_wrong_way():
    turn = {"position": (8.0, 0.0, 1.0)}
    course = track((GATE, turn, {**GATE, "direction": "backward"}))
    assert met(course, (0, 0, 1), (9, 0, 1), (0, 0, 1)) == [(PASSED, name) for name in ("gate 1", "gate 2", "gate 3")]


def test_gates_count_in_their_order_alone():
    first, second = {**GATE, "position": (6.0, 0.0, 1.0)}, GATE
    found = met(track((first, second)), (0, 0, 1), (8, 0, 1))
    assert found == [(PASSED, "gate 1"), (MISSED, "gate 2")]


def test_a_thin_pole_between_two_rows_of_the_path_is_touched():
    assert met(track(poles=({"position": (2.0, 0.05), "radius": 0.001},)), (0, 0, 1), (8, 0, 1)) == [
        (Kind.OBSTACLE, "pole 1"),
        (PASSED, "gate 1"),
    ]


@pytest.mark.parametrize(
    ("bounds", "kind", "name"),
    [
        ({"floor": 0.95}, Kind.FLOOR, "the floor"),
        ({"ceiling": 1.45}, Kind.CEILING, "the ceiling"),
        ({"box": {"low": (-1.0, -1.0, 0.0), "high": (9.0, 1.0, 1.45)}}, Kind.BOX, "the box"),
    ],
)
def test_leaving_the_bounds_is_met_once_for_each_time(bounds, kind, name):
    height = 0.9 if kind is Kind.FLOOR else 1.4
    path = [(0, 0, 1), (1, 0, height), (2, 0, 1), (2.5, 0, height), (3, 0, 1), (8, 0, 1)]
    assert [found for found in met(track(**bounds), *path) if found[0] is not PASSED] == [(kind, name)] * 2


def test_a_drone_that_stands_on_the_lower_side_of_the_box_touches_nothing():
    box = {"low": (-1.0, -1.0, 0.0), "high": (9.0, 1.0, 2.0)}
    assert met(track(box=box), (0, 0, 0), (2, 0, 1), (8, 0, 1)) == [(PASSED, "gate 1")]
    assert (Kind.BOX, "the box") in met(track(box=box), (0, 0, -0.01), (2, 0, 1), (8, 0, 1))


def test_balls_around_the_same_place_are_passed_one_after_the_other():
    course = track(({"position": (3.0, 0.0, 1.0), "radius": 0.5}, {"position": (3.0, 0.1, 1.0), "radius": 0.5}))
    assert met(course, (0, 0, 1), (8, 0, 1)) == [(PASSED, "gate 1"), (PASSED, "gate 2")]
