"""Whatever the rule, pieces cover the plan and do not depend on where it lies; each rule does what it says."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hotlap.files.descriptions import load_race
from hotlap.planning import plan
from hotlap.reference.reference import Reference
from hotlap.reference.segmentation import SegmentationRule, SegmentClass, Segments, segment

FLAT, ASCENT, DESCENT, STEEP = SegmentClass.FLAT, SegmentClass.ASCENT, SegmentClass.DESCENT, SegmentClass.STEEP
MIRROR = {ASCENT: DESCENT, DESCENT: ASCENT}
PERIOD = 0.01

every_rule = pytest.mark.parametrize("rule", list(SegmentationRule))
tenths = st.integers(-80, 80).map(lambda tenth: tenth / 10)
legs = st.lists(st.tuples(tenths, tenths, tenths, st.floats(0.05, 4)), min_size=1, max_size=10)  # velocity [m/s] and how long [s]
angles = st.floats(-np.pi, np.pi)


def reference_of(velocity: np.ndarray, duration: float | None = None, run_out: float = 0.0) -> Reference:
    """A reference of positions and velocities alone, with half a second of run-out at some climb rate."""
    velocity = np.vstack([velocity, np.tile([0.0, 0.0, run_out], (50, 1))])
    position = np.cumsum(velocity, axis=0) * PERIOD
    rows, end = len(velocity), (len(velocity) - 51) * PERIOD
    attitude, zeros, rotors = np.tile([1.0, 0.0, 0.0, 0.0], (rows, 1)), np.zeros((rows, 3)), np.full((rows, 4), 2.0)
    duration = end if duration is None else duration
    return Reference(position, attitude, velocity, zeros, np.full(rows, 9.81), rotors, np.array([duration]), duration, period=PERIOD)


def fly(legs: list[tuple[float, float, float, float]]) -> np.ndarray:
    """Velocities every 10 ms, shape (rows, 3), that go from one to the next within a quarter of a second."""
    steps = np.concatenate([np.tile(leg[:3], (round(leg[3] * 100) + 1, 1)) for leg in legs])
    padded = np.vstack([np.tile(steps[0], (24, 1)), steps])
    return np.stack([np.convolve(column, np.full(25, 1 / 25), "valid") for column in padded.T], axis=1)


def circle(speed: float, radius: float, seconds: float, *, upright: bool = False) -> np.ndarray:
    """Velocities around a circle, level or as a loop."""
    angle = speed / radius * PERIOD * np.arange(round(seconds * 100) + 1)
    cosine, sine, none = speed * np.cos(angle), speed * np.sin(angle), 0 * angle
    return np.stack([cosine, none, sine] if upright else [cosine, sine, none], axis=1)


def straight(speeds: list[tuple[float, float]]) -> np.ndarray:
    """Velocities along x, from (time, speed) to (time, speed)."""
    times, values = zip(*speeds, strict=True)
    speed = np.interp(np.arange(round(times[-1] * 100) + 1) * PERIOD, times, values)
    return np.stack([speed, 0 * speed, 0 * speed], axis=1)


SHAPES = {
    "a point": np.zeros((2, 3)),
    "a moment": straight([(0, 3), (0.5, 3)]),
    "short": straight([(0, 3), (1.99, 3)]),
    "level": straight([(0, 5), (9, 5)]),
    "vertical": straight([(0, 5), (9, 5)])[:, [1, 2, 0]],
    "falling": -straight([(0, 5), (9, 5)])[:, [1, 2, 0]],
    "a loop": circle(6.0, 5.0, 6.0, upright=True),
    "a circle": circle(10.0, 20.0, 12.0),
    "stop and go": straight([(0, 0), (2, 24), (4, 0), (6, 24), (8, 0)]),
}


def check(segments: Segments, duration: float) -> None:
    """Pieces follow each other from 0 to the end, and each segment is of one class and has at least one of them."""
    pieces = segments.pieces
    assert pieces[0].start == 0
    assert pieces[-1].end == segments.duration == duration
    assert all(piece.end == after.start for piece, after in pairwise(pieces))
    assert all(piece.start < piece.end for piece in pieces)
    assert len(pieces) == len(segments.starts) == len(segments.classes)
    assert list(dict.fromkeys(piece.segment for piece in pieces)) == list(range(len(segments)))
    assert all(segments.segment_classes[piece.segment] is piece.kind for piece in pieces)
    middles = np.array([(piece.start + piece.end) / 2 for piece in pieces] + [duration + 5])
    assert segments.at(middles).tolist() == [piece.segment for piece in pieces] + [pieces[-1].segment]


def assert_same(segments: Segments, others: Segments, *, mirrored: bool = False) -> None:
    np.testing.assert_array_equal(others.starts, segments.starts)
    assert others.owners == segments.owners
    assert others.classes == tuple(MIRROR.get(kind, kind) if mirrored else kind for kind in segments.classes)


@every_rule
@given(legs=legs)
def test_pieces_cover_the_plan(rule, legs):
    reference = reference_of(fly(legs))
    check(segment(reference, rule), reference.duration)


@every_rule
def test_rows_at_another_period_are_cut_alike(rule):
    usual = reference_of(fly([(5.0, 0.0, 0.0, 4.0), (3.0, 0.0, 2.0, 4.0), (5.0, 0.0, 0.0, 4.0), (1.0, 0.0, -4.0, 4.0)])[:-1])
    rows = {name: getattr(usual, name)[::2] for name in ("position", "attitude", "velocity", "rates", "thrust", "rotor_thrusts")}
    cut, coarse = segment(usual, rule), segment(replace(usual, **rows, period=2 * PERIOD), rule)
    assert coarse.classes == cut.classes
    np.testing.assert_allclose(coarse.starts, cut.starts, atol=2 * PERIOD)


@every_rule
@pytest.mark.parametrize("name", SHAPES)
def test_pieces_cover_any_shape(rule, name):
    reference = reference_of(SHAPES[name])
    check(segment(reference, rule), reference.duration)


@every_rule
def test_a_plan_may_end_between_two_rows(rule):
    reference = reference_of(SHAPES["stop and go"], duration=8.004)
    check(segment(reference, rule), 8.004)


@every_rule
@given(legs=legs, yaw=angles, shift=st.floats(-300, 300))
def test_where_a_track_lies_and_which_way_it_points_does_not_matter(rule, legs, yaw, shift):
    velocity, (c, s) = fly(legs), (np.cos(yaw), np.sin(yaw))
    reference, turned = reference_of(velocity), reference_of(velocity @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]))
    turned.position[:] += shift
    assert_same(segment(reference, rule), segment(turned, rule))


@every_rule
@given(legs=legs)
def test_a_mirrored_track_is_cut_alike_and_upside_down_swaps_ascent_and_descent(rule, legs):
    velocity = fly(legs)
    segments = segment(reference_of(velocity), rule)
    assert_same(segments, segment(reference_of(velocity * [1, -1, 1]), rule))
    assert_same(segments, segment(reference_of(velocity * [1, 1, -1]), rule), mirrored=True)


@every_rule
@given(legs=legs)
def test_the_run_out_changes_nothing(rule, legs):
    assert_same(segment(reference_of(fly(legs)), rule), segment(reference_of(fly(legs), run_out=-90.0), rule))


def test_the_papers_rule_is_the_default():
    reference = reference_of(SHAPES["a loop"])
    assert_same(segment(reference), segment(reference, SegmentationRule.PAPER))


@pytest.mark.parametrize(("rule", "least"), [(SegmentationRule.RELEASED_1M, 2.0), (SegmentationRule.RELEASED_3M, 2.0)])
@given(legs=legs)
def test_pieces_last_as_long_as_their_rule_says(rule, least, legs):
    lengths = [piece.end - piece.start for piece in segment(reference_of(fly(legs)), rule).pieces]
    assert len(lengths) == 1 or min(lengths) > least - 1e-9


@pytest.mark.parametrize(("rate", "one", "three"), [(0.9, FLAT, FLAT), (2.0, ASCENT, FLAT), (-2.9, DESCENT, FLAT), (3.0, ASCENT, ASCENT)])
def test_the_released_files_differ_in_how_far_an_ascent_rises(rate, one, three):
    reference = reference_of(np.tile([5.0, 0.0, rate], (901, 1)))
    assert segment(reference, SegmentationRule.RELEASED_1M).classes == (one,)
    assert segment(reference, SegmentationRule.RELEASED_3M).classes == (three,)


def test_the_released_code_halves_nothing():
    reference = reference_of(SHAPES["vertical"])
    assert STEEP in segment(reference).classes
    assert segment(reference, SegmentationRule.RELEASED_1M).classes == segment(reference, SegmentationRule.RELEASED_3M).classes == (ASCENT,)


@pytest.mark.parametrize(("name", "one", "three"), [("qualifier-20", 6, 8), ("circle-34", 1, 1), ("flip-16", 4, 4)])
def test_how_many_segments_built_in_races_have_by_the_released_code(name, one, three):
    reference = plan(load_race(name))
    assert [len(segment(reference, rule)) for rule in (SegmentationRule.RELEASED_1M, SegmentationRule.RELEASED_3M)] == [one, three]


def test_thresholds_are_those_that_are_asked_for():
    reference = reference_of(np.vstack([np.tile([4.0, 0.0, rate], (300, 1)) for rate in (0.0, 2.0, 0.0, -6.0, 0.0)]))
    asked = segment(reference, rise=3.0, ahead=1.02, slope=math.inf)
    assert_same(asked, segment(reference, SegmentationRule.RELEASED_3M))
    assert len(segment(reference, rise=1.0)) > len(segment(reference, rise=5.0)) > len(segment(reference, rise=50.0)) == 1
    assert len(segment(reference, least=7.6)) == 1
    assert len(segment(reference, SegmentationRule.EQUAL_TIME, piece=1.0)) == 15
    with pytest.raises(TypeError, match="height"):
        segment(reference, height=3.0)


@given(legs)
def test_none_is_one_segment(legs):
    assert len(segment(reference_of(fly(legs)), SegmentationRule.NONE)) == 1


@pytest.mark.parametrize("sign", [1, -1])
def test_none_is_what_most_of_the_plan_is(sign):
    for rising, kind in ((3.0, FLAT), (7.0, ASCENT if sign > 0 else DESCENT)):
        velocity = np.vstack([np.tile([5.0, 0.0, sign * 2.0], (round(rising * 100), 1)), np.tile([5.0, 0.0, 0.0], (600, 1))])
        assert segment(reference_of(velocity), SegmentationRule.NONE).classes == (kind,)


@given(st.floats(0.02, 60))
def test_equal_times_are_equal_and_about_two_seconds(seconds):
    reference = reference_of(straight([(0, 5), (seconds, 5)]))
    lengths = np.array([piece.end - piece.start for piece in segment(reference, SegmentationRule.EQUAL_TIME).pieces])
    assert np.ptp(lengths) < PERIOD + 1e-9
    assert reference.duration < 2 or 1.3 < lengths.mean() < 3


def test_pieces_may_share_a_segment():
    segments = Segments(np.array([0.0, 2.0, 4.0, 6.0]), (ASCENT, DESCENT) * 2, 8.0, (0, 1, 0, 1))
    check(segments, 8.0)
    assert segments.segment_classes == (ASCENT, DESCENT)
    assert len(segments) == 2
    assert segments.at(np.array([1.0, 3.0, 5.0, 7.0, 99.0])).tolist() == [0, 1, 0, 1, 1]
