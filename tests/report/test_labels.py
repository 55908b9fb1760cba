"""Labels lie inside, apart from each other, and beside the path where they can."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hotlap.report.labels import Placer, group, number


@pytest.mark.parametrize(
    ("gates", "text"),
    [([1], "1"), ([1, 2], "1, 2"), ([3, 4, 5, 6], "3–6"), ([1, 4, 5, 6], "1, 4–6"), ([1, 3, 5, 7], "1, 3, 5…"), ([2, 1, 2], "1, 2")],
)
def test_numbers_are_given_once_and_join(gates, text):
    assert number(gates) == text


@given(st.lists(st.tuples(st.floats(0.5, 5.5), st.floats(0.5, 3.5)), min_size=1, max_size=8))
def test_labels_lie_inside(points):
    placer = Placer((6.0, 4.0), np.array(points))
    for point in points:
        x, y = placer.place(np.array(point), 0.2, 0.1, gap=0.05)
        assert 0.1 <= x <= 5.9
        assert 0.05 <= y <= 3.95


def test_labels_of_one_point_do_not_overlap():
    placer = Placer((4.0, 4.0), np.zeros((0, 2)))
    places = [placer.place(np.array([2.0, 2.0]), 0.3, 0.1, gap=0.05) for _ in range(6)]
    for i, first in enumerate(places):
        for second in places[:i]:
            apart = np.abs(first - second) - (0.3, 0.1)
            assert apart.max() > -1e-9


def test_a_label_keeps_off_the_path():
    path = np.stack([np.linspace(0, 4, 400), np.full(400, 2.0)], axis=1)
    _, y = Placer((4.0, 4.0), path).place(np.array([2.0, 2.0]), 0.3, 0.1, gap=0.05)
    assert abs(y - 2.0) > 0.05


def test_near_points_share_a_group():
    groups = group(np.array([[0, 0], [3, 0], [0.05, 0], [3, 0.05]]), 0.1)
    assert [members for _, members in groups] == [[0, 2], [1, 3]]
