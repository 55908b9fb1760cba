"""Gates become targets: balls, planes, or two planes with a way through them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.planning.targets import targets_of
from hotlap.race.track import Track

from . import small

SQUARE = {"position": (5.0, 0.0, 1.5), "yaw": 0.0, "side": 1.4}


def targets(*gates: Any, radius: float = 0.2, clearance: float | None = None, **track: Any) -> Any:
    race = small.make_race(planning={"clearance": clearance})
    own = Track.model_validate({"name": "hall", "start": (0.0, 0.0, 1.5), "gates": gates, **track})
    return targets_of(race.model_copy(update={"track": own, "vehicle": race.vehicle.model_copy(update={"radius": radius})}))


def test_a_bare_point_is_a_ball_of_the_tolerance_and_one_that_does_not_count_has_all_of_its_own():
    point, ball = targets((5.0, 0.0, 1.0), {"position": (8.0, 0.0, 1.0), "radius": 0.6, "counts": False})
    assert (point.radius, ball.radius, point.plane, ball.plane) == (0.2, 0.6, None, None)


@pytest.mark.parametrize(("clearance", "radius"), [(None, 0.3), (0.0, 0.6), (0.1, 0.5), (0.9, 0.3)])
def test_a_ball_that_counts_is_entered_by_the_clearance_but_never_beyond_half_of_it(clearance, radius):
    (ball,) = targets({"position": (5.0, 0.0, 1.0), "radius": 0.6}, clearance=clearance)
    assert ball.radius == pytest.approx(radius)


def test_a_gate_with_a_direction_is_two_planes_as_far_away_as_the_vehicle_reaches():
    entry, exit_ = targets({**SQUARE, "depth": 1.0})
    assert_allclose([entry.position[0], exit_.position[0]], [5.0 - 0.7, 5.0 + 0.7])
    assert (entry.inside, exit_.inside) == (False, True)


def test_a_gate_passed_either_way_is_one_plane():
    (target,) = targets({**SQUARE, "direction": "either"})
    assert target.along == 0
    assert not target.inside


def test_a_point_without_size_needs_a_speed_for_its_direction():
    (target,) = targets(SQUARE, radius=0.0)
    assert target.speed > 0


@pytest.mark.parametrize(("clearance", "inset"), [(None, 0.45), (0.0, 0.2), (0.3, 0.5)])
def test_the_rim_is_kept_clear_of_by_radius_and_clearance(clearance, inset):
    assert_allclose([target.inset for target in targets(SQUARE, clearance=clearance)], inset)


def test_a_free_circle_takes_no_account_of_the_vehicle():
    entry, exit_ = targets({"position": (5.0, 0.0, 1.5), "yaw": 0.0})
    assert (entry.inset, entry.radius) == (exit_.inset, exit_.radius) == (0.0, 0.2)


def test_gates_near_to_each_other_have_less_depth():
    first, through, last, beyond = targets(SQUARE, {**SQUARE, "position": (5.3, 0.0, 1.5)})
    assert first.along == pytest.approx(-0.12)
    assert through.position[0] < last.position[0]
    assert beyond.position[0] > last.position[0]


def test_rows_hold_within_the_opening_and_only_there():
    entry, exit_ = targets(SQUARE)
    rows = exit_.rows(last=6, count=3)
    assert set(rows.nodes.tolist()) == {4, 5, 6}
    inner = rows.nodes < 6

    def kept(y: float) -> bool:
        values = rows.coefficients[inner, :3] @ np.array([5.0, y, 1.5])
        return bool(((values >= rows.low[inner]) & (values <= rows.high[inner])).all())

    assert kept(0.24)
    assert not kept(0.26)
    assert set(entry.rows(last=3, count=3).nodes.tolist()) == {3}


def test_names_are_those_of_the_track():
    found = targets((1.0, 0.0, 1.0), {**SQUARE, "counts": False}, laps=2, end=(9.0, 0.0, 1.0))
    assert [target.waypoint for target in found] == ["gate 1 of lap 1", "point 2 of lap 1", "point 2 of lap 1", "gate 1 of lap 2",
        "point 2 of lap 2", "point 2 of lap 2", "the end"]  # fmt: skip
