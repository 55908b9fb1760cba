"""Pictures and page show the same openings, arrows, obstacles and borders, to scale, and large enough to be seen."""

from __future__ import annotations

import re

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Circle, PathPatch, Polygon, Rectangle

from fake_world import make_scenario
from hall import BALL, EITHER, GATES, POINT, make_hall
from hotlap.race.race import GateRule, JudgeSettings
from hotlap.race.track import Track
from hotlap.report import figures
from hotlap.report.page.static_map import draw_track_map
from hotlap.report.projection import scene_views
from hotlap.report.scene import stage
from hotlap.report.silhouettes import borders
from hotlap.report.standing import DOTTED, LEAST
from hotlap.report.style import QUIET

ORIENTED = [gate for gate in GATES if gate.oriented]


@pytest.fixture(scope="module")
def scene():
    return stage(make_hall())


@pytest.fixture(scope="module")
def drawn(scene):
    return figures.track(scene)


def patches(figure: Figure, view: int, kind: type) -> list:
    return [patch for patch in figure.axes[view].patches if type(patch) is kind]


def lines(figure: Figure, view: int, points: int) -> list[np.ndarray]:
    """Lines of so many points in a view."""
    return [line.get_xydata() for line in figure.axes[view].lines if len(line.get_xydata()) == points]


def outlines(figure: Figure, view: int) -> list[np.ndarray]:
    return [patch.get_xy() for patch in patches(figure, view, Polygon) if not patch.get_fill()]


@pytest.mark.parametrize("view", [0, 1])
def test_openings_are_drawn_to_scale_where_they_stand(scene, drawn, view):
    seen = scene_views(scene)[view]
    wanted = [seen.project(rim) for shape in scene.structures.distinct for rim in shape.rims]
    found = outlines(drawn, view)
    assert len(found) == len(wanted) == len(ORIENTED) + 1  # both ends of the tunnel
    for rim in wanted:
        assert any(len(one) == len(rim) and np.allclose(one, rim) for one in found)


@pytest.mark.parametrize("view", [0, 1])
def test_every_frame_is_there_and_every_gate_without_orientation_is_a_circle(drawn, view):
    assert len(patches(drawn, view, PathPatch)) == sum(gate.frame > 0 for gate in GATES) + 1
    circles = {(*patch.center, patch.radius) for patch in patches(drawn, view, Circle) if not patch.get_fill()}
    up = 1 + view
    assert circles == {(BALL.position[0], BALL.position[up], BALL.radius), (POINT.position[0], POINT.position[up], 1.3)}


def test_every_one_way_gate_has_an_arrow_in_a_view_and_those_passed_either_way_have_none(drawn):
    tails = [[tuple(np.round(line[0], 6)) for line in lines(drawn, view, 5) if len(line) == 5] for view in (0, 1)]
    for gate in ORIENTED:
        x, y, z = gate.position
        if gate.depth:
            continue  # begins at the end of the tunnel
        assert ((x, y) in tails[0] or (x, z) in tails[1]) == (gate is not EITHER)


@pytest.mark.parametrize("view", [0, 1])
def test_every_obstacle_is_filled(drawn, view):
    filled = [patch for patch in drawn.axes[view].patches if mpl.colors.to_hex(patch.get_edgecolor()) == QUIET and patch.get_fill()]
    rounds = [patch for patch in filled if isinstance(patch, Circle)]
    squares = [patch for patch in filled if isinstance(patch, Rectangle)]
    assert (len(rounds), len(squares)) == ((3, 1) if view == 0 else (1, 3))


@pytest.mark.parametrize("view", [0, 1])
def test_box_floor_and_ceiling_are_dotted_lines(scene, drawn, view):
    wanted = list(borders(scene.structures, scene_views(scene)[view]))
    dotted = [line.get_xydata() for line in drawn.axes[view].lines if getattr(line, "_unscaled_dash_pattern", None) == DOTTED]
    assert len(dotted) == len(wanted) > 3
    np.testing.assert_allclose(dotted, wanted)


def test_colours_are_for_data_only(drawn):
    for axes in drawn.axes[:2]:
        for patch in axes.patches:
            colours = [patch.get_edgecolor(), *([patch.get_facecolor()] if patch.get_fill() else [])]
            assert all(red == green == blue for red, green, blue, _ in colours)


def test_a_small_gate_on_a_long_track_is_large_enough_to_be_seen():
    apart = [gate.model_copy(update={"position": tuple(100 * np.array(gate.position))}) for gate in GATES]
    long = stage(make_hall(Track(name="long", start=(0.0, 0.0, 1.0), gates=tuple(apart))))
    figure = figures.track(long)
    width, axes = figure.get_size_inches()[0], figure.axes[0]
    scale = axes.get_position().width * width / np.ptp(axes.get_xlim())
    for rim in outlines(figure, 0):
        assert scale * np.linalg.norm(rim - rim[:-1].mean(axis=0), axis=1).max() > 0.4 * LEAST
    assert {patch.radius for patch in patches(figure, 0, Circle) if not patch.get_fill()} >= {1.3}  # a bare point keeps its circle


def points_of(svg: str, pattern: str) -> list[np.ndarray]:
    return [np.array([pair.split(",") for pair in text.split()], dtype=float) for text in re.findall(pattern, svg)]


def test_the_map_of_the_page_shows_the_same_openings_and_arrows(scene, drawn):
    for view, part in enumerate(draw_track_map(scene).split("<g>")[1:]):
        rims = points_of(part, r'<polygon points="([^"]*)" fill="none"')
        arrows = points_of(part, r'<polyline points="([^"]*)"[^>]*class="way"')
        assert len(rims) == len(outlines(drawn, view))
        assert len(arrows) == len([line for line in lines(drawn, view, 5) if not np.array_equal(line[0], line[-1])])
        assert part.count('class="obstacles"') == 1


def test_the_map_of_a_track_of_bare_points_has_circles_and_nothing_else():
    assert not re.search("polygon|obstacles|way|dasharray", draw_track_map(stage(make_scenario())))


@pytest.mark.parametrize("rule", list(GateRule))
def test_the_chart_of_the_error_shows_the_distance_that_counts_only_where_it_decides(rule):
    axes = figures.tracking_error(stage(make_hall(judge=JudgeSettings(rule=rule, distance=1.1)))).axes[0]
    assert any(np.allclose(line.get_ydata(), 1.1) for line in axes.lines) == (rule is not GateRule.OPENING)
