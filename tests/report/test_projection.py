"""All drawings of a track share their geometry: what is in sight, where it lies, and what covers what."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fake_world import make_scenario
from hotlap.report import figures
from hotlap.report.map import draw_map
from hotlap.report.page.static_map import draw_track_map
from hotlap.report.projection import LEAST_EXTENT, Layer, box_of, scene_views, views_of, widen
from hotlap.report.scene import stage

coordinates = st.lists(st.tuples(*[st.floats(-200, 200)] * 3), min_size=2, max_size=9).map(np.array)


@given(coordinates, st.floats(0, 10), st.floats(0, 0.5))
def test_a_wider_box_holds_the_points_about_the_same_middle(points, least, margin):
    low, high = box_of(points)
    wide = widen(low, high, least, margin)
    assert ((wide[0] <= low) & (wide[1] >= high)).all()
    assert (wide[1] - wide[0] >= least - 1e-9).all()
    np.testing.assert_allclose(sum(wide), low + high, atol=1e-9)


@given(coordinates)
def test_both_views_have_the_longer_side_across_and_x_to_the_right_or_y_to_the_left(points):
    low, high = widen(*box_of(points), LEAST_EXTENT)
    above, side = views_of(low, high)
    assert above.across == side.across == int(high[0] - low[0] < high[1] - low[1])
    assert (above.up, side.up) == (1 - above.across, 2)
    right, up = above.place(above.project(points), 3.0).T
    sign = 1 if above.across == 0 else -1
    np.testing.assert_allclose(np.diff(right), 3 * sign * np.diff(points[:, above.across]), atol=1e-9)
    np.testing.assert_allclose(np.diff(up), 3 * np.diff(points[:, above.up]), atol=1e-9)
    assert ((right >= -1e-9) & (right <= 3 * above.extent[0] + 1e-9)).all()
    middle = above.place_from_middle(above.project(points), 3.0)
    np.testing.assert_allclose(middle + 3 * above.extent / 2, np.column_stack([right, up]), atol=1e-9)


def test_what_lies_beyond_a_view_is_moved_to_its_edge():
    view, _ = views_of(np.zeros(3), np.array([2.0, 9.0, 1.0]))
    far = view.project(np.array([[1.0, 100.0, 0.0], [-5.0, 3.0, 0.0]]))
    np.testing.assert_array_equal(view.clip(far), [[9.0, 1.0], [3.0, 0.0]])


def test_the_picture_and_the_map_of_the_page_show_the_gates_in_the_same_places():
    scene = stage(make_scenario())
    above, side = scene_views(scene)
    circles = re.findall(r'<circle cx="(\S+)" cy="(\S+)"[^>]*fill="none"', draw_track_map(scene))
    drawn = np.array(circles, dtype=float).reshape(2, -1, 2)
    for axes, view, places in zip(figures.track(scene).axes, (above, side), drawn, strict=False):
        np.testing.assert_allclose((*axes.get_xlim(), *axes.get_ylim()), (view.low[0], view.high[0], view.low[1], view.high[1]))
        centres = np.array([patch.center for patch in axes.patches if not patch.get_fill()])
        scale = np.ptp(places[:, 0]) / np.ptp(centres[:, 0])
        np.testing.assert_allclose(np.diff(places, axis=0) * [1, -1], np.diff(view.place(centres, scale), axis=0), atol=0.15)


def test_parts_that_cover_others_come_later_in_every_drawing():
    first = draw_track_map(stage(make_scenario())).split("<g>")[1]
    assert first.index('fill-opacity="0.08"') < first.index("<polyline") < first.index('stroke-opacity="0.6"')
    assert list(Layer) == sorted(Layer)


@pytest.mark.parametrize("slope", [1e-16, -1e-16, 0.0])
def test_gates_of_a_straight_track_lie_on_its_line_in_the_terminal(slope):
    """Rounding errors do not move dots to the next row."""
    scenario = make_scenario()
    along = np.linspace(0, 90, len(scenario.reference.position))
    reference = replace(scenario.reference, position=np.column_stack([2 + slope * along, along, np.ones(len(along))]))
    gates = np.column_stack([np.full(5, 2.0), np.linspace(10, 80, 5), np.ones(5)])
    lines = [line for line in draw_map(reference, gates, scenario.segments).split("\n\n")[0].split("\n") if not line.startswith("from")]
    with_gates = [line for line in lines if line.count("o") == 5]
    assert len(with_gates) == 2
    assert all(sum(0x2800 < ord(letter) < 0x2900 for letter in line) > 50 for line in with_gates)
