"""The map fits a terminal, shows every gate, and is text."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fake_world import make_scenario
from hotlap.files.descriptions import load_race, load_track
from hotlap.planning import plan
from hotlap.reference.segmentation import segment
from hotlap.report.map import draw_map, draw_track

ANSI = re.compile("\x1b\\[[0-9]*m")


def draw(name: str, **options) -> str:
    race = load_race(name)
    reference = plan(race)
    return draw_map(reference, race.track.gate_positions, segment(reference), **options)


def wander(points: np.ndarray):
    """A scenario along a polyline, shape (n, 3), with a gate at each corner."""
    scenario = make_scenario()
    rows = np.linspace(0, len(points) - 1, 501)
    position = np.stack([np.interp(rows, np.arange(len(points)), column) for column in points.T], axis=1)
    position = np.vstack([position, np.tile(position[-1], (200, 1))])
    return replace(scenario.reference, position=position), points[1:], scenario.segments


coordinates = st.lists(st.tuples(*[st.floats(-200, 200)] * 3), min_size=2, max_size=9).map(np.array)


@given(coordinates, st.integers(1, 120), st.integers(1, 50))
def test_the_map_stays_within_its_size(points, width, height):
    lines = draw_map(*wander(points), width=width, height=height).splitlines()
    views = lines[: lines.index("")]
    assert max(len(line) for line in lines) <= max(width, 30)
    assert len(views) <= max(height, 8)


@given(coordinates)
def test_start_and_gates_are_marked(points):
    text = draw_map(*wander(points))
    assert text.count("S") == 2
    assert "o" in text.replace("from above", "")


@pytest.mark.parametrize("name", ["circle-34", "qualifier-20"])
def test_every_gate_of_a_race_has_its_number(name):
    lines = draw(name).splitlines()
    numbers = {int(text) for line in lines[1 : lines.index("")] for text in re.findall(r"\d+", line)}
    assert set(range(1, len(load_race(name).track.gates) + 1)) <= numbers


def test_a_still_reference_is_a_dot():
    text = draw_map(*wander(np.zeros((2, 3))))
    assert "S" in text


def test_colour_is_only_paint():
    plain, painted = draw("qualifier-20"), draw("qualifier-20", colour=True)
    assert "\x1b" not in plain
    assert "\x1b" in painted
    assert ANSI.sub("", painted) == plain


def test_segments_are_listed_in_order():
    text = draw("qualifier-20").split("\n\n")[1]
    assert re.findall(r"(\d) (\w+)", " ".join(re.findall(r"\d [a-z]\w{3,}", text))) == [
        (str(i + 1), kind.value) for i, kind in enumerate(segment(plan(load_race("qualifier-20"))).classes)
    ]


def test_a_track_is_drawn_in_straight_lines_with_every_gate():
    text = draw_track(load_track("drop"), width=100, height=30)
    assert "from above" in text
    assert all(str(gate) in text for gate in range(1, 13))
    assert max(map(len, text.splitlines())) <= 100


def test_the_longer_side_runs_across():
    along_x = draw_map(*wander(np.array([[0, 0, 0], [50, 10, 0.0]])))
    along_y = draw_map(*wander(np.array([[0, 0, 0], [10, 50, 0.0]])))
    assert "x→ 50 m" in along_x
    assert "y← 50 m" in along_y
    rows = [line for line in along_y.splitlines() if "S" in line]
    assert rows[0].rindex("S") > 40  # y runs to the left: the start at y = 0 is on the right
