"""Obstacles and borders have the outline that is seen from above or from the side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from hall import HALL
from hotlap.race.gate_plane import plane_of
from hotlap.race.obstacles import Box, Pole, Sphere
from hotlap.report.projection import views_of
from hotlap.report.silhouettes import Disc, Slab, arrow_in, arrow_length, borders, silhouette
from hotlap.report.structures import GateShape, structures_of
from race.gates import oriented_gates

ABOVE, SIDE = views_of(np.array([-10.0, -5.0, 0.0]), np.array([30.0, 15.0, 8.0]))


def test_a_pole_is_round_from_above_and_upright_from_the_side():
    pole = Pole(position=(3.0, 4.0), radius=0.5, bottom=1.0)
    above, side = silhouette(pole, ABOVE), silhouette(pole, SIDE)
    assert isinstance(above, Disc)
    np.testing.assert_array_equal([*above.centre, above.radius], [3, 4, 0.5])
    assert isinstance(side, Slab)
    np.testing.assert_array_equal([side.low, side.high], [[2.5, 1], [3.5, 8]])


def test_a_sphere_is_round_and_a_box_is_not_from_wherever_they_are_seen():
    sphere, box = Sphere(position=(1.0, 2.0, 3.0), radius=2.0), Box(low=(0.0, 1.0, 2.0), high=(3.0, 5.0, 7.0))
    for view, up in ((ABOVE, 1), (SIDE, 2)):
        round_one, square_one = silhouette(sphere, view), silhouette(box, view)
        assert isinstance(round_one, Disc)
        np.testing.assert_array_equal(round_one.centre, [1, 1 + up])
        assert isinstance(square_one, Slab)
        np.testing.assert_array_equal([square_one.low, square_one.high], [[0, up], [3, box.high[up]]])


@pytest.mark.parametrize("view", [ABOVE, SIDE])
@pytest.mark.parametrize("obstacle", [Pole(position=(3.0, 4.0), radius=1e-4), Sphere(position=(1.0, 2.0, 3.0), radius=1e-4)])
def test_a_thin_obstacle_is_drawn_thick_enough_to_be_seen(obstacle, view):
    shape = silhouette(obstacle, view, least=0.2)
    assert (shape.radius if isinstance(shape, Disc) else (shape.high - shape.low)[0] / 2) == pytest.approx(0.2)


@pytest.mark.parametrize(("view", "count"), [(ABOVE, 4), (SIDE, 6)])
def test_box_floor_and_ceiling_are_lines_and_lie_within_the_view(view, count):
    known = structures_of(HALL.model_copy(update={"box": Box(low=(-6.0, -4.0, 0.5), high=(29.0, 14.0, 7.5))}), 1.3)
    lines = list(borders(known, view))
    assert len(lines) == count
    for line in lines:
        np.testing.assert_array_equal(view.clip(line), line)
        assert (line[0] == line[1]).sum() == 1


def test_sides_of_the_box_beyond_the_view_are_left_out_and_the_others_cut():
    known = replace(structures_of(HALL, 1.3), box=Box(low=(0.0, -900.0, -900.0), high=(900.0, 900.0, 900.0)), floor=None, ceiling=99.0)
    (line,) = borders(known, ABOVE)
    np.testing.assert_array_equal(np.sort(line, axis=0), [[0, -5], [0, 15]])


@given(oriented_gates)
def test_the_arrow_of_a_gate_is_seen_in_one_of_both_views_at_least(gate):
    shape = GateShape(gate, plane_of(gate, 1.3), 1.3)
    arrows = [arrow_in(shape, view, 1.0) for view in (ABOVE, SIDE)]
    assert any(arrow is not None for arrow in arrows) == (shape.normal is not None)
    for arrow, view in zip(arrows, (ABOVE, SIDE), strict=True):
        if arrow is not None:
            np.testing.assert_allclose(arrow[1] - arrow[0], view.project(shape.normal[None])[0], atol=1e-9)


@given(oriented_gates)
def test_an_arrow_is_neither_too_short_to_be_seen_nor_too_long(gate):
    shape = GateShape(gate, plane_of(gate, 1.3), 1.3)
    for scale in (1e-3, 0.1, 10.0):
        assert 0.1 - 1e-9 <= scale * arrow_length(shape, scale, (0.1, 0.3)) <= 0.3 + 1e-9
