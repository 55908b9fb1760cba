"""Under the rule "opening" a gate is passed where the drone crosses its plane inside of its opening, in order and in its direction."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from hotlap.core.errors import HotlapError
from hotlap.core.records import Cause, End
from hotlap.race.gate import Gate, PassingDirection
from hotlap.race.gate_plane import plane_of
from hotlap.race.track import Track

from .judging import Path, crash, fly_track, outcome

SPEED = 2.0
TIMES = (1.0, 2.0, 3.0)


def row(**opening: Any) -> Track:
    """Three gates along x, two metres apart."""
    gates = tuple(Gate(position=(SPEED * t, 0.0, 0.0), yaw=0.0, **opening) for t in TIMES)
    return Track(name="row", start=(0.0, 0.0, 0.0), gates=gates)


def straight(left: float = 0.0, up: float = 0.0, late: float = 0.0) -> Path:
    return lambda t: (SPEED * (t - late), left, up)


def corners(*points: tuple[float, ...], speed: float = SPEED) -> tuple[Path, list[float]]:
    """A path along straight lines, and the times at its corners."""
    line = np.array(points)
    times = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))) / speed
    return (lambda t: tuple(np.interp(t, times, column) for column in line.T)), times.tolist()


SQUARE = {"width": 1.0, "height": 0.6}


@pytest.mark.parametrize("radius", [0.0, 0.1])
@pytest.mark.parametrize(("left", "up", "edge"), [(1.0, 0.0, 0.5), (-1.0, 0.0, 0.5), (0.0, 1.0, 0.3), (0.0, -1.0, 0.3)])
def test_passing_ends_at_the_rim_less_the_vehicles_radius(left, up, edge, radius):
    for off, passed in ((edge - radius - 1e-6, 3), (edge - radius + 1e-6, 0)):
        v = fly_track(row(**SQUARE), TIMES, straight(off * left, off * up), straight(), radius=radius)
        assert outcome(v) == (passed, End.FINISHED if passed else End.MISSED)
        assert_allclose(v.rim_distance[1, 0], off - edge + radius, atol=1e-12)


def test_a_lap_ends_where_the_last_plane_is_crossed():
    v = fly_track(row(radius=0.4), TIMES, straight(0.1, late=0.123), straight())
    assert outcome(v) == (3, End.FINISHED)
    assert v.lap_time[1] == v.end_time[1] == pytest.approx(3.123)
    assert_allclose(v.end_position[1], [6.0, 0.1, 0.0], atol=1e-12)
    assert_allclose(v.rim_distance[1], -0.3, atol=1e-12)


def test_a_miss_is_known_at_the_plane():
    v = fly_track(row(radius=0.4), TIMES, straight(0.5), straight())
    assert outcome(v) == (0, End.MISSED)
    assert v.end_time[1] == pytest.approx(1.0)
    assert np.isnan(v.rim_distance[1, 1:]).all()


def test_without_an_opening_the_judges_distance_is_one_and_the_vehicles_size_does_not_count():
    for off, passed in ((1.2999, 3), (1.3001, 0)):
        assert outcome(fly_track(row(), TIMES, straight(off), straight(), radius=0.5))[0] == passed


@pytest.mark.parametrize(("direction", "passed"), [("forward", 0), ("backward", 3), ("either", 3)])
def test_a_gate_is_passed_in_its_direction(direction, passed):
    gates = tuple(Gate(position=(x, 0.0, 0.0), yaw=math.pi, radius=0.4, direction=PassingDirection(direction)) for x in (2.0, 4.0, 6.0))
    track = Track(name="row", start=(0.0, 0.0, 0.0), gates=gates)
    v = fly_track(track, TIMES, straight(0.1))
    assert outcome(v) == (passed, End.FINISHED if passed else End.MISSED)
    if not passed:
        assert v.end_time[1] == pytest.approx(1.0 + 2.0, abs=0.02)  # it might have come back until then
        assert v.rim_distance[1, 0] > 0


def test_through_from_behind_and_back_again_counts_once_in_its_direction():
    path, times = corners((3.0, 0, 0), (1.0, 0, 0), (3.0, 0, 0))
    track = Track(name="one", start=(3.0, 0.0, 0.0), gates=(Gate(position=(2.0, 0, 0), yaw=0.0, radius=0.4),))
    v = fly_track(track, [1.5], path)
    assert times[1] == 1.0
    assert outcome(v) == (1, End.FINISHED)
    assert v.lap_time[1] == pytest.approx(1.5)


def test_flying_past_a_gate_sideways_does_not_pass_it():
    track = Track(name="one", start=(0.0, 0.0, 0.0), gates=(Gate(position=(2.0, 0, 0), yaw=math.pi / 2, radius=0.4),))
    v = fly_track(track, [1.0], straight(0.01), last=4.0)
    assert outcome(v) == (0, End.MISSED)


STACKED, STACK_TIMES = corners((0.0, 0, 0), (4.0, 0, 0), (4.0, 0, 1.5), (0.0, 0, 1.5))
STACK = Track(
    name="stack",
    start=(0.0, 0.0, 0.0),
    gates=(Gate(position=(2.0, 0, 0), yaw=0.0, side=1.0), Gate(position=(2.0, 0, 1.5), yaw=math.pi, side=1.0)),
)


def test_two_gates_above_each_other_are_passed_there_and_back():
    v = fly_track(STACK, [1.0, STACK_TIMES[2] + 1.0], STACKED)
    assert outcome(v) == (2, End.FINISHED)


def test_the_upper_gate_first_is_the_mirror_image_and_passes_nothing():
    v = fly_track(STACK, [1.0, STACK_TIMES[2] + 1.0], lambda t: (*STACKED(t)[:2], 1.5 - STACKED(t)[2]), STACKED)
    assert outcome(v)[0] == 0


def test_the_same_plane_crossed_elsewhere_on_the_track_is_no_miss():
    """A hairpin: gate 1 stands behind the turn, and the way there crosses its plane in its direction beside it."""
    path, times = corners((0.0, 0, 0), (2.0, 0, 0), (2.0, 2.0, 0), (-1.0, 2.0, 0), (-1.0, 4.0, 0), (4.0, 4.0, 0), speed=8.0)
    gate = Gate(position=(1.0, 4.0, 0), yaw=0.0, radius=0.5)
    v = fly_track(Track(name="hairpin", start=(0.0, 0.0, 0.0), gates=(gate,)), [times[4] + 0.25], path)
    assert outcome(v) == (1, End.FINISHED)
    assert v.lap_time[1] == pytest.approx(times[4] + 0.25)


def test_a_gate_met_again_in_the_next_lap_is_another_passage():
    """A circle flown twice; a gate missed in the first lap is not passed in the second."""
    gates = tuple(Gate(position=(math.sin(a), 1 - math.cos(a), 0.0), yaw=a, radius=0.3) for a in (1.0, 3.0, 5.0))
    track = Track(name="laps", start=(0.0, 0.0, 0.0), gates=gates, laps=2)
    circle = lambda t: (math.sin(4 * t), 1 - math.cos(4 * t), 0.0)  # noqa: E731
    times = [(a + 2 * math.pi * lap) / 4 for lap in (0, 1) for a in (1.0, 3.0, 5.0)]
    assert outcome(fly_track(track, times, circle)) == (6, End.FINISHED)
    astray = lambda t: (*circle(t)[:2], 0.5 * (0.6 < t < 0.9))  # noqa: E731
    for fly_on in (False, True):
        v = fly_track(track, times, astray, circle, fly_on=fly_on)
        assert outcome(v) == (1, End.MISSED)
        assert np.isfinite(v.rim_distance[1]).sum() == (6 if fly_on else 2)


def test_gates_count_in_order():
    """The second gate first: it counts only when it is passed again after the first."""
    there, again = (
        ((0.0, 0, 0), (0.0, 3.0, 0), (3.0, 3.0, 0), (3.0, 0, 0), (5.0, 0, 0)),
        ((5.0, 3.0, 0), (0.0, 3.0, 0), (0.0, 0, 0), (9.0, 0, 0)),
    )
    path, _ = corners(*there, *again, speed=8.0)
    track = Track(name="two", start=(0.0, 0.0, 0.0), gates=tuple(Gate(position=(x, 0, 0), yaw=0.0, radius=0.4) for x in (2.0, 4.0)))
    v = fly_track(track, [2.0, 2.4], path, window=(3.0, 3.0), crash=30.0)
    assert outcome(v) == (2, End.FINISHED)
    assert v.lap_time[1] > 3.0


def test_two_gates_may_be_passed_in_one_period():
    gates = tuple(Gate(position=(x, 0.0, 0.0), yaw=0.0, radius=0.4) for x in (2.03, 2.05, 2.17))
    track = Track(name="near", start=(0.0, 0.0, 0.0), gates=gates)
    v = fly_track(track, [1.015, 1.025, 1.085], straight(), period=0.1)
    assert outcome(v) == (3, End.FINISHED)
    assert v.lap_time[1] == pytest.approx(1.085)


def test_balls_and_bare_points_count_in_order_by_their_own_radius():
    gates = (Gate(position=(2.0, 0.5, 0.0), radius=0.6), Gate(position=(4.0, 0.5, 0.0)), Gate(position=(6.0, 0.5, 0.0), radius=0.4))
    track = Track(name="balls", start=(0.0, 0.0, 0.0), gates=gates)
    v = fly_track(track, TIMES, straight(), radius=0.3, distance=0.51)
    assert outcome(v) == (2, End.MISSED)
    assert_allclose(v.rim_distance[1], [-0.1, -0.01, 0.1], atol=1e-9)
    v = fly_track(track, TIMES, straight(0.2), straight(), radius=0.3, distance=0.51)
    assert outcome(v) == (3, End.FINISHED)
    assert v.lap_time[1] == pytest.approx(3.0)


def test_after_a_miss_the_gates_behind_it_go_on_being_measured():
    def path(t: float) -> tuple[float, float, float]:
        return SPEED * t, 0.3 + 0.4 * (0.5 < t < 1.5), 0.0

    v = fly_track(row(radius=0.4), TIMES, path, straight(), fly_on=True)
    assert outcome(v) == (0, End.MISSED)
    assert v.end_time[1] == pytest.approx(1.0)
    assert_allclose(v.rim_distance[1], [0.3, -0.1, -0.1], atol=1e-12)


def test_a_gate_that_is_never_crossed_has_its_closest_distance():
    v = fly_track(row(radius=0.4), TIMES, lambda t: (min(SPEED * t, 1.5), 0.0, 0.0), straight(), window=(0.5, 0.5))
    assert outcome(v) == (0, End.MISSED)
    assert v.end_time[1] == pytest.approx(1.5, abs=0.011)
    assert v.rim_distance[1, 0] == pytest.approx(0.5)


TUNNEL = Track(name="tunnel", start=(0.0, 0.0, 0.0), gates=(Gate(position=(3.0, 0, 0), yaw=0.0, side=1.0, depth=2.0),))


@pytest.mark.parametrize(
    ("points", "passed"),
    [
        (((0.0, 0, 0), (6.0, 0, 0)), 1),
        (((0.0, 0.49, 0), (6.0, -0.49, 0)), 1),
        (((0.0, 0, 0), (3.0, 0, 0), (3.5, 0.9, 0), (4.5, 0, 0), (6.0, 0, 0)), 0),  # out through the wall and in again
        (((0.0, 0.9, 0), (2.5, 0.9, 0), (2.5, 0, 0), (6.0, 0, 0)), 0),  # in through the wall
        (((0.0, 0, 0), (2.5, 0, 0), (2.5, 0.9, 0), (6.0, 0.9, 0)), 0),
        (((0.0, 0, 0), (3.5, 0, 0), (1.5, 0, 0), (6.0, 0, 0)), 1),  # back out of the entrance, and again
    ],
)
def test_a_tunnel_is_passed_from_end_to_end(points, passed):
    path, _ = corners(*points, speed=4.0)
    for period in (0.01, 0.125):
        v = fly_track(TUNNEL, [0.75], path, straight(), period=period)
        assert outcome(v)[0] == passed


def test_a_tunnel_within_one_period_is_passed():
    v = fly_track(TUNNEL, [0.1], lambda t: (30.0 * t, 0.3, 0.0), period=0.15)
    assert outcome(v) == (1, End.FINISHED)
    assert v.lap_time[1] == pytest.approx(4.0 / 30)


def test_touching_a_frame_is_a_crash_and_beyond_it_a_miss():
    framed = row(radius=0.4, frame=0.1)
    for off, end in ((0.29, End.FINISHED), (0.31, End.CRASHED), (0.59, End.CRASHED), (0.61, End.MISSED)):
        v = fly_track(framed, TIMES, straight(off), straight(), radius=0.1)
        assert outcome(v)[1] is end
        assert crash(v) == ((Cause.FRAME, 0) if end is End.CRASHED else (Cause.NONE, -1))


@settings(max_examples=30, deadline=None)
@given(
    yaw=st.floats(-3.1, 3.1), pitch=st.floats(-1.5, 1.5), roll=st.floats(-3.1, 3.1),
    left=st.floats(-0.8, 0.8), up=st.floats(-0.8, 0.8), shape=st.sampled_from([{"radius": 0.5}, {"width": 1.2, "height": 0.7}]),
)  # fmt: skip
def test_a_gate_turned_with_its_flight_is_judged_alike(yaw, pitch, roll, left, up, shape):
    gate = Gate(position=(1.0, -2.0, 3.0), yaw=yaw, pitch=pitch, roll=roll, **shape)
    plane = plane_of(gate, 1.0)
    assert plane is not None
    rim = float(plane.rim_distance(np.array([left, up]))) + 0.1
    turned = lambda l, u: lambda t: plane.centre + plane.rotation @ [SPEED * t - 2.0, l, u]  # noqa: E731
    track = Track(name="one", start=tuple((plane.centre - 2 * plane.normal).tolist()), gates=(gate,))
    v = fly_track(track, [1.0], turned(left, up), turned(0.0, 0.0), radius=0.1, last=2.0)
    assert v.rim_distance[1, 0] == pytest.approx(rim, abs=1e-9)
    assert (outcome(v)[0] == 1) == (rim <= 0) or abs(rim) < 1e-9


def test_an_opening_smaller_than_the_vehicle_is_refused():
    with pytest.raises(HotlapError, match=r"row, gate 1: its opening has room for a radius of 0\.3 m, the vehicle has one of 0\.35 m"):
        fly_track(row(**SQUARE), TIMES, straight(), radius=0.35)
