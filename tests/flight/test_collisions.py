"""A flight crashes where it touches an obstacle, a frame, the floor, the ceiling or the box, and says which."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from hotlap.core.records import Cause, End
from hotlap.race.gate import Gate
from hotlap.race.obstacles import Box, Pole, Sphere
from hotlap.race.race import GateRule
from hotlap.race.track import Track

from .judging import Path, crash, fly_track, outcome

SPEED, RADIUS = 2.0, 0.1
AFAR = Pole(position=(2.0, 30.0), radius=0.5)
EVERY_RULE = pytest.mark.parametrize("rule", GateRule)


def track(**around: Any) -> Track:
    """One bare gate in front of what stands around."""
    return Track(**{"name": "yard", "start": (0.0, 0.0, 0.0), "gates": (Gate(position=(8.0, 0.0, 0.0)),), **around})


def straight(left: float = 0.0, up: float = 0.0) -> Path:
    return lambda t: (SPEED * t, left, up)


def fly(place: Track, path: Path, **options: Any) -> Any:
    return fly_track(place, [4.0], path, straight(), radius=RADIUS, crash=20.0, distance=5.0, **options)


OBSTACLES = [
    ({"poles": (AFAR, Pole(position=(3.0, 0.5), radius=0.2))}, Cause.POLE, 0.2, 0.8),
    ({"spheres": (Sphere(position=(3.0, 0.5, 0.0), radius=0.2),)}, Cause.SPHERE, 0.2, 0.8),
    ({"boxes": (Box(low=(2.5, 0.3, -1.0), high=(3.5, 0.7, 1.0)),)}, Cause.BOX, 0.2, 0.8),
]


@EVERY_RULE
@pytest.mark.parametrize(("around", "cause", "low", "high"), OBSTACLES)
def test_an_obstacle_is_touched_nearer_than_the_vehicles_radius(around, cause, low, high, rule):
    for left, touched in ((low - 1e-3, False), (low + 1e-3, True), (high - 1e-3, True), (high + 1e-3, False)):
        v = fly(track(**around), straight(left), rule=rule, last=7.0)
        assert outcome(v) == ((0, End.CRASHED) if touched else (1, End.FINISHED))
        assert crash(v) == ((cause, len(around.get("poles", [0])) - 1) if touched else (Cause.NONE, -1))


def test_a_thin_pole_is_touched_between_two_samples():
    thin = track(poles=(Pole(position=(3.0, 0.0), radius=0.005),))
    v = fly_track(thin, [0.2], lambda t: (40.0 * t, 0.0, 0.0), radius=0.0, period=0.05)
    assert crash(v) == (Cause.POLE, 0)
    assert v.end_time[1] == pytest.approx(2.995 / 40, abs=1e-4)
    assert v.end_position[1, 0] == pytest.approx(2.995, abs=2e-3)


@pytest.mark.parametrize(("up", "touched"), [(0.55, True), (0.65, False), (-0.55, True), (-0.65, False)])
def test_a_pole_ends_at_its_top_and_bottom(up, touched):
    v = fly(track(poles=(Pole(position=(3.0, 0.0), radius=0.2, bottom=-0.5, top=0.5),)), straight(0.0, up), last=7.0)
    assert (outcome(v)[1] is End.CRASHED) == touched


@EVERY_RULE
@pytest.mark.parametrize(
    ("around", "wrong", "cause"),
    [
        ({"ceiling": 1.0}, (0.0, 0.0, 0.95), Cause.CEILING),
        ({"box": Box(low=(-1.0, -1.0, -1.0), high=(9.0, 1.0, 1.0))}, (0.0, 0.95, 0.0), Cause.OUTSIDE),
        ({"box": Box(low=(-1.0, -1.0, -1.0), high=(9.0, 1.0, 1.0))}, (0.0, 0.0, 0.95), Cause.OUTSIDE),
        ({"box": Box(low=(-1.0, -1.0, -1.0), high=(9.0, 1.0, 1.0))}, (0.0, 0.0, -1.1), Cause.OUTSIDE),
        ({"floor": -1.0}, (0.0, 0.0, -1.1), Cause.FLOOR),
        ({}, (0.0, 25.0, 0.0), Cause.DISTANCE),
        ({}, (math.nan, 0.0, 0.0), Cause.NUMBERS),
    ],
)
def test_what_lies_around_is_not_left(around, wrong, cause, rule):
    v = fly(track(**around), lambda t: np.add((SPEED * t, 0.0, 0.0), wrong if t > 1.0 else (0, 0, 0)), rule=rule)
    assert outcome(v) == (0, End.CRASHED)
    assert crash(v) == (cause, -1)


def test_the_frames_of_all_gates_are_solid_under_every_rule():
    gates = (Gate(position=(8.0, 0, 0), yaw=0.0, side=1.0), Gate(position=(4.0, 0.0, 0.0), yaw=0.5, side=1.0, frame=0.1))
    for rule in GateRule:
        around = Track(name="yard", start=(0.0, 0.0, 0.0), gates=gates)
        for left, touched in ((0.0, False), (0.6, True)):
            v = fly_track(around, [4.0, 6.0], straight(left), straight(), radius=RADIUS, rule=rule, last=3.0)
            assert crash(v) == ((Cause.FRAME, 1) if touched else (Cause.NONE, -1))


def on_the_ground(depth: float) -> Path:
    """Sinks into the ground, rises, and comes down again."""
    return lambda t: (SPEED * t, 0.0, -depth if t < 1 else 1.0 if t < 2 else -0.05)


def test_the_floor_counts_after_take_off():
    ground = track(floor=0.0)
    v = fly(ground, on_the_ground(0.3))
    assert crash(v) == (Cause.FLOOR, -1)
    assert v.end_time[1] == pytest.approx(2.0, abs=0.011)


def test_sinking_deep_into_the_ground_is_a_crash_before_take_off_too():
    v = fly(track(floor=0.0), on_the_ground(0.6))
    assert crash(v) == (Cause.FLOOR, -1)
    assert v.end_time[1] < 0.1


def test_a_flight_that_starts_above_the_floor_has_taken_off():
    v = fly(track(floor=-1.0), lambda t: (SPEED * t, 0.0, 0.0 if t < 1 else -1.01))
    assert crash(v) == (Cause.FLOOR, -1)
    assert v.end_time[1] == pytest.approx(1.0, abs=0.011)


@EVERY_RULE
@pytest.mark.parametrize(("gates", "outcomes"), [((2.05, 6.0), (1, End.CRASHED)), ((2.05,), (1, End.FINISHED))])
def test_gates_passed_before_the_touch_in_the_same_period_count(gates, outcomes, rule):
    place = Track(
        name="wall",
        start=(0.0, 0.0, 0.0),
        gates=tuple(Gate(position=(x, 0, 0), yaw=0.0, radius=1.0) for x in gates),
        boxes=(Box(low=(2.17, -1.0, -1.0), high=(3.0, 1.0, 1.0)),),
    )
    times = [x / SPEED for x in gates]
    v = fly_track(place, times, straight(), radius=0.05, period=0.2, rule=rule, distance=1.0)
    assert outcome(v) == outcomes
    assert crash(v) == ((Cause.BOX, 0) if outcomes[1] is End.CRASHED else (Cause.NONE, -1))
