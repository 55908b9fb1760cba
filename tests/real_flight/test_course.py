"""Geofence, place, and the paths to the start and from the end."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hotlap.core.errors import InputError
from hotlap.race.obstacles import Box
from hotlap.race.track import Gate, Track
from hotlap.real_flight.course import Course
from hotlap.real_flight.geofence import geofence_of
from hotlap.real_flight.link import Seen
from hotlap.real_flight.paths import braking_of, level, path_from_rest, with_braking, yaw_of
from hotlap.real_flight.place import Place, read_place
from hotlap.real_flight.settings import FlightSettings
from hotlap.reference.attitude import thrust_axis
from real_flight.hangar import make_scenario

PATH = np.array([[0.0, 0.0, 1.0], [5.0, -2.0, 3.0]])
TRACK = Track(
    name="line", start=(0.0, 0.0, 1.0), gates=(Gate(position=(5.0, -2.0, 3.0)),), floor=0.0, box=Box(low=(-1, -9, -1), high=(9, 9, 9))
)


def test_the_geofence_lies_around_the_path_and_within_the_track():
    fence = geofence_of(PATH, TRACK, margin=2.0)
    assert fence.low.tolist() == [-1.5, -4.0, -0.5]  # half a metre beyond box and floor
    assert fence.high.tolist() == [7.0, 2.0, 5.0]
    assert not any(fence.outside(point) for point in PATH)
    assert all(fence.outside(point) for point in (fence.high + 0.1, fence.low - 0.1, np.full(3, np.nan)))


def test_a_geofence_that_is_given_is_taken():
    assert geofence_of(PATH, TRACK, "-1,9,-8,8,0,4").words == "x -1.0 to 9.0, y -8.0 to 8.0, z 0.0 to 4.0 m"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("1,2,3", "must be six numbers"),
        ("a,b,c,d,e,f", "must be six numbers"),
        ("0,9,0,9,0,inf", "must be six numbers"),
        ("9,-1,-8,8,0,4", "x must go from a smaller number to a larger one"),
        ("-1,4,-8,8,0,4", r"the flight leaves it at \(5\.0, -2\.0, 3\.0\) m: it needs x 0\.0 to 5\.0"),
    ],
)
def test_a_geofence_that_does_not_do_is_one_line(text, reason):
    with pytest.raises(InputError, match=f"geofence: .*{reason}"):
        geofence_of(PATH, TRACK, text)


NUMBERS = st.floats(-5.0, 5.0)


@given(values=st.lists(NUMBERS, min_size=13, max_size=13), origin=st.lists(NUMBERS, min_size=4, max_size=4))
def test_what_is_seen_in_the_race_is_told_where_it_was(values, origin):
    state = np.array(values)
    state[3:7] = level(state[3])
    place = Place(np.array(origin[:3]), origin[3])
    seen = place.seen(Seen(0.0, 0.0, state, armed=True, engaged=True))
    assert place.told(seen.state) == pytest.approx(state, abs=1e-9)
    assert np.linalg.norm(seen.state[7:10]) == pytest.approx(np.linalg.norm(state[7:10]))
    assert seen.state[10:].tolist() == state[10:].tolist()


def test_a_place_is_read_in_metres_and_degrees():
    place = read_place("1,2,0.5,90")
    state = np.concatenate([[1.0, 3.0, 0.5], level(np.pi / 2), [0.0, 2.0, 0.0], np.zeros(3)])
    seen = place.seen(Seen(0.0, 0.0, state, armed=True, engaged=True)).state
    assert seen[:3] == pytest.approx([1.0, 0.0, 0.0])
    assert seen[7:10] == pytest.approx([2.0, 0.0, 0.0])
    assert yaw_of(seen[3:7]) == pytest.approx(0.0)
    assert read_place("here") is None
    with pytest.raises(InputError, match=r"origin: must be x, y, z .* not '1,2'"):
        read_place("1,2")


@pytest.mark.check
def test_a_start_far_away_is_flown_to_only_within_a_geofence_that_was_given():
    scenario = make_scenario()
    state = np.concatenate([[100.0, 0.0, 1.0], level(0.0), np.zeros(6)])
    parameters = scenario.space.first_guess(1)
    with pytest.raises(InputError, match="origin: the start of the race is 100 m from the vehicle"):
        Course(scenario, parameters, FlightSettings()).approach(state, stands=False)
    given = "-20,120,-20,20,0,9"
    _, fence = Course(scenario, parameters, FlightSettings(geofence=given)).approach(state, stands=False)
    assert fence.high.tolist() == [120, 20, 9]


def test_a_path_goes_from_rest_to_rest_within_its_limits():
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [4.0, 3.0, 2.0]])
    path = path_from_rest(points, (3.0, -3.0), 1.0, 0.8, 9.81)
    assert path.position[0].tolist() == [0, 0, 0]
    assert path.position[-1] == pytest.approx(points[-1])
    assert np.linalg.norm(path.velocity, axis=1).max() <= 1.0 + 1e-6
    slopes = np.gradient(path.position, path.period, axis=0)
    assert np.abs(slopes[1:-1] - path.velocity[1:-1]).max() < 0.01
    assert [yaw_of(path.attitude[0]), yaw_of(path.attitude[-1])] == pytest.approx([3.0, -3.0], abs=1e-6)
    turned = np.unwrap([yaw_of(one) for one in path.attitude])
    assert abs(turned[-1] - turned[0]) < 0.3  # by the shorter way


def test_a_race_ends_with_a_stand_at_the_height_of_its_end():
    scenario = make_scenario()
    braked, rows = with_braking(scenario).reference, scenario.reference.planned_rows
    for name in ("position", "attitude", "velocity", "rates", "thrust"):
        assert (getattr(braked, name)[:rows] == getattr(scenario.reference, name)[:rows]).all()
    assert braked.velocity[-1].tolist() == [0, 0, 0]
    assert braked.position[-1, 2] == pytest.approx(1.0, abs=0.05)
    assert thrust_axis(braked.attitude[-1])[2] > 0.999
    steps = np.diff(braked.velocity, axis=0) / braked.period
    level_speeding = np.linalg.norm(steps[rows + 70 :, :2], axis=1)
    assert level_speeding.max() < 1.1 * braking_of(scenario)
    assert np.abs(np.diff(steps, axis=0)).max() < 2.0  # m/s^2 from row to row: no jolt
    assert np.abs(np.diff(braked.position, axis=0) / braked.period - braked.velocity[:-1]).max() < 0.2
