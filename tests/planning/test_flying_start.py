"""Flying starts are refused where nothing can stop the vehicle in time, and only there."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.core.errors import PlanningError
from hotlap.planning.flying_start import refuse_flying_start
from hotlap.planning.problem import Problem

from .test_openings import LAST, RADIUS, SQUARE, make_race

FREE = {"nodes": 8, "clearance": 0.0}
BEHIND = (-4.0, 0.0, 1.5)  # a point that no vehicle is at before it has stopped


def check(velocity: tuple[float, float, float], *gates: object, v_max: float = 34.0, **track: object) -> None:
    refuse_flying_start(Problem.of(make_race(*gates, planning={**FREE, "v_max": v_max}, start_velocity=velocity, **track)))


REFUSED = {
    "the box": ((0.0, -25.0, 0.0), {"box": {"low": (-9.0, -4.0, -9.0), "high": (9.0, 9.0, 9.0)}}, "the wall at y = -4 m"),
    "the ceiling": ((0.0, 0.0, 20.0), {"ceiling": 2.5}, "the wall at z = 2.5 m"),
    "the floor": ((0.0, 0.0, -20.0), {"floor": 0.5}, "the floor"),
    "a box": ((25.0, 0.0, 0.0), {"boxes": ({"low": (2.0, -5.0, -5.0), "high": (3.0, 5.0, 5.0)},)}, "box 1"),
    "a sphere": ((25.0, 0.0, 0.0), {"spheres": ({"position": (1.5, 0.1, 1.5), "radius": 0.8},)}, "sphere 1"),
}


@pytest.mark.parametrize(("velocity", "track", "name"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_avoided_is_named_with_the_start_velocity(velocity, track, name):
    with pytest.raises(PlanningError, match=f"start_velocity: at 2[05] m/s even full thrust does not keep the vehicle from {name}"):
        check(velocity, BEHIND, **track)
    check(tuple(0.1 * np.array(velocity)), BEHIND, **track)


def test_the_room_needed_before_a_wall_is_that_of_full_thrust_and_drag():
    velocity = 12.0
    quadrotor = Problem.of(make_race(BEHIND, planning=FREE)).quadrotor
    room = velocity**2 / 2 / quadrotor.max_acceleration + RADIUS
    near = {"low": (-9.0, -9.0, -9.0), "high": (0.6 * room, 9.0, 9.0)}
    with pytest.raises(PlanningError, match="start_velocity"):
        check((velocity, 0.0, 0.0), BEHIND, box=near)
    check((velocity, 0.0, 0.0), BEHIND, box=near, v_max=4.0)  # drag helps
    check((velocity, 0.0, 0.0), BEHIND, box={"low": (-9.0, -9.0, -9.0), "high": (1.01 * room, 9.0, 9.0)})


def test_what_stands_behind_the_last_gate_refuses_nothing():
    wall = {"boxes": ({"low": (9.0, -9.0, -9.0), "high": (20.0, 9.0, 9.0)},)}
    check((40.0, 0.0, 0.0), {**SQUARE, "frame": 0.0}, **wall)
    with pytest.raises(PlanningError, match="box 1"):
        check((40.0, 0.0, 0.0), {**SQUARE, "frame": 0.0}, (25.0, 0.0, 1.5), **wall)


def test_a_start_beyond_all_speeds_is_refused():
    with pytest.raises(PlanningError, match="start_velocity: 500 m/s is more than the 100 m/s"):
        check((500.0, 0.0, 0.0), LAST)
