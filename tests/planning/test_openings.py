"""Plans go through openings in their direction, around what stands in the way, and begin and end as the track asks for."""

from __future__ import annotations

import dataclasses
import runpy
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.core.errors import PlanningError
from hotlap.planning import plan
from hotlap.planning.cache import key
from hotlap.planning.planner import find_plan
from hotlap.planning.problem import Problem, Trajectory
from hotlap.planning.sampling import gate_times, states_at
from hotlap.race.gate_plane import plane_of
from hotlap.race.race import PlanDynamics, Race
from hotlap.race.track import Track
from reference.passages import PASSED, Met, find_all

from . import small

RADIUS = 0.2
SQUARE = {"position": (5.0, 0.0, 1.5), "yaw": 0.0, "side": 1.4, "frame": 0.2}
LAST = {"position": (10.0, 3.0, 1.5), "yaw": 0.8, "radius": 0.7}


def make_race(*gates: Any, planning: dict[str, Any] | None = None, **track: Any) -> Race:
    """A race of a vehicle of 0.2 m radius on a track of its own."""
    race = small.make_race(planning={"nodes": 8, **(planning or {})})
    own = Track.model_validate({"name": "hall", "start": (0.0, 0.0, 1.5), "gates": gates, **track})
    return race.model_copy(update={"track": own, "vehicle": race.vehicle.model_copy(update={"radius": RADIUS})})


RACES = {
    "in line": make_race(SQUARE, LAST),
    "flipped": make_race({**SQUARE, "yaw": np.pi}, (9.0, 0.0, 1.5)),
    "there and back": make_race(SQUARE, (9.0, 1.0, 1.5), {**SQUARE, "direction": "backward"}),
    "there, and back either way": make_race(SQUARE, (9.0, 1.0, 1.5), {**SQUARE, "direction": "either"}, (0.0, 0.0, 1.5)),
    "tunnel": make_race({**SQUARE, "position": (6.0, 2.0, 1.5), "depth": 2.0}, LAST),
    "tunnel either way": make_race({**SQUARE, "yaw": np.pi, "depth": 1.0, "direction": "either"}, LAST),
    "orientation alone": make_race({"position": (5.0, 0.0, 1.5), "yaw": 0.5}, LAST),
    "stacked": make_race(SQUARE, {**SQUARE, "position": (5.0, 0.0, 3.4), "yaw": np.pi}),
    "two laps, closed": make_race(SQUARE, {**LAST, "yaw": 2.4}, (2.0, 5.0, 1.5), laps=2, closed=True),
    "obstacles in line": make_race(
        SQUARE,
        LAST,
        poles=({"position": (2.5, 0.0), "radius": 0.05},),
        spheres=({"position": (7.6, 1.5, 1.5), "radius": 0.4},),
        boxes=({"low": (2.0, 0.8, 0.0), "high": (3.0, 1.8, 3.0)},),
    ),
    "pole in the middle": make_race({**SQUARE, "side": 2.0}, LAST, poles=({"position": (5.0, 0.0), "radius": 0.1},)),
    "within walls": make_race(SQUARE, LAST, floor=0.0, box={"low": (-0.2, -1.0, 0.0), "high": (10.9, 4.0, 2.2)}),
    "points at a wall": make_race(
        (5.0, 0.9, 1.5), (9.0, 0.0, 1.5), (5.0, 0.9, 1.5), box={"low": (-1.0, -1.0, 0.0), "high": (9.5, 1.0, 3.0)}
    ),
    "points below a ceiling": make_race((5.0, 0.5, 1.9), (9.0, 0.0, 1.9), (5.0, 0.9, 1.7), ceiling=2.0),
    "all dynamics": make_race(
        SQUARE, LAST, planning={"dynamics": PlanDynamics.FULL, "quadrotor": None}, end=(14.0, 4.0, 1.5), end_at_rest=True
    ),
    "at rest, flying start": make_race(
        {**SQUARE, "counts": False}, LAST, start_velocity=(4.0, 0.0, 1.0), end=(14.0, 4.0, 1.5), end_at_rest=True, ceiling=2.6
    ),
}

FEW = ("in line", "within walls", "two laps, closed", "obstacles in line")  # the others take too long for every day
each_race = pytest.mark.parametrize("name", [name if name in FEW else pytest.param(name, marks=pytest.mark.check) for name in RACES])


@cache
def planned(name: str) -> tuple[Race, Problem, Trajectory]:
    race = RACES[name]
    problem = Problem.of(race)
    return race, problem, find_plan(problem)


@cache
def met(name: str) -> list[Met]:
    race, problem, trajectory = planned(name)
    times = np.append(np.arange(0.0, trajectory.duration, 0.001), trajectory.duration)
    positions = states_at(problem, trajectory, times)[0][:, :3]
    return find_all(times, positions, race.track, RADIUS, race.planning.tolerance)


@each_race
def test_every_gate_is_passed_in_turn_and_nothing_is_touched(name):
    assert [kind for kind, *_ in met(name)] == [PASSED] * len(RACES[name].track.counted)


@each_race
def test_gate_times_are_those_at_which_the_planes_are_crossed(name):
    race, problem, trajectory = planned(name)
    times = gate_times(problem, trajectory)
    assert len(times) == len(race.track.counted)
    assert (np.diff(times) > 0).all()
    places = states_at(problem, trajectory, times)[0][:, :3]
    for gate, place in zip(race.track.counted, places, strict=True):
        plane = plane_of(gate, race.planning.tolerance)
        if plane is not None:
            assert_allclose(plane.to_gate(place)[0], 0.0, atol=1e-3)
            assert plane.rim_distance(plane.to_gate(place)[1:]) + (RADIUS if plane.solid else 0.0) < 1e-3


def test_a_flying_start_and_an_end_at_rest_are_kept():
    _, _, trajectory = planned("at rest, flying start")
    assert_allclose(trajectory.states[0, 3:6], [4.0, 0.0, 1.0], atol=1e-6)
    assert_allclose(trajectory.states[-1, [3, 4, 5, 7, 8, 10, 11, 12]], 0.0, atol=1e-6)


@pytest.mark.check
def test_rotors_hover_where_a_plan_with_all_dynamics_ends():
    _, problem, trajectory = planned("all dynamics")
    assert_allclose(trajectory.states[-1, 13:17], problem.quadrotor.mass * problem.quadrotor.gravity / 4, rtol=1e-5)


def test_a_clearance_is_kept_from_the_rim():
    race, problem, trajectory = planned("in line")
    wide = find_plan(Problem.of(make_race(SQUARE, LAST, planning={"clearance": 0.0})))
    assert wide.duration < trajectory.duration
    places = states_at(problem, trajectory, gate_times(problem, trajectory))[0][:, :3]
    for gate, place in zip(race.track.counted, places, strict=True):
        plane = plane_of(gate, 0.2)
        assert plane is not None
        assert plane.rim_distance(plane.to_gate(place)[1:]) < -(RADIUS + plane.room) / 2 + 1e-3


@pytest.mark.check
def test_a_gate_that_is_walled_in_is_refused_by_what_is_in_the_way():
    walls = [{"low": (3.0, -500.0, -500.0), "high": (4.0, 500.0, 500.0)}]
    with pytest.raises(PlanningError, match="gate 1: no way to it was found; the best one touches box 1"):
        plan(make_race(LAST, boxes=tuple(walls), planning={"nodes": 4}), cache=False)


REFUSED = {
    "an opening that is too small": (make_race(LAST, {**SQUARE, "side": 0.3}), r"no plan for hall, gate 2: the opening has room for"),
    "a clearance that is too large": (make_race(SQUARE, LAST, planning={"clearance": 0.6}), r"gate 1: .* and a clearance of 0\.6 m"),
    "a lap": (make_race(LAST, {**SQUARE, "side": 0.3}, laps=2), "gate 2 of lap 1: the opening"),
    "a start in an obstacle": (
        make_race(LAST, spheres=({"position": (0.2, 0.0, 1.5), "radius": 0.1},)),
        r"the start is 0\.1 m from sphere 1, and the vehicle needs its radius of 0\.2 m",
    ),
    "a point in an obstacle": (
        make_race((5.0, 0.0, 1.5), poles=({"position": (5.0, 0.0), "radius": 0.5},)),
        "gate 1: its middle is 0 m from pole 1",
    ),
    "a start at the box": (
        make_race(LAST, box={"low": (-1.0, -0.1, 0.0), "high": (11.0, 4.0, 3.0)}),
        r"the start is 0\.1 m from the box, and the vehicle needs its radius of 0\.2 m",
    ),
    "a start at the box, before points": (
        make_race((5.0, 0.5, 1.5), box={"low": (-1.0, -0.1, 0.0), "high": (11.0, 4.0, 3.0)}),
        r"the start is 0\.1 m from the box",
    ),
    "a start below the ceiling": (make_race(LAST, ceiling=1.6), r"the start is 0\.1 m from the ceiling"),
    "an opening that the box cuts off": (
        make_race(LAST, {**SQUARE, "position": (5.0, -0.25, 1.5), "side": 0.5}, box={"low": (-1.0, -0.3, 0.0), "high": (11.0, 4.0, 3.0)}),
        "gate 2: its opening is blocked by the box",
    ),
    "an opening below the floor": (
        make_race(LAST, {**SQUARE, "position": (5.0, 0.0, -0.8)}, planning={"floor": 0.0}),
        "gate 2: its opening lies below the floor at 0 m",
    ),
    "an opening that is blocked": (
        make_race(LAST, SQUARE, boxes=({"low": (4.9, -0.6, 0.8), "high": (5.1, 0.6, 2.2)},)),
        "gate 2: its opening is blocked by box 1",
    ),
}


@pytest.mark.parametrize(("race", "words"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_flown_is_refused_by_name(race, words):
    with pytest.raises(PlanningError, match=words):
        plan(race, cache=False)


@pytest.mark.check
@pytest.mark.parametrize("seed", [1000, 1001, 1002, 1003])
@pytest.mark.parametrize("dynamics", PlanDynamics)
def test_random_tracks_pass_a_test_that_shares_no_code_with_the_planner(seed, dynamics):
    source = Path(__file__).parents[2] / "benchmarks" / "random_openings.py"
    outcome = runpy.run_path(str(source))["try_one"](seed, dynamics)
    assert outcome.duration is not None, outcome.refused
    assert not outcome.faults


@pytest.mark.check
def test_the_direction_of_a_gate_changes_the_plan():
    forward = find_plan(Problem.of(make_race(SQUARE, (9.0, 0.0, 1.5))))
    assert planned("flipped")[2].duration > forward.duration + 0.5
    either = find_plan(Problem.of(make_race({**SQUARE, "yaw": np.pi, "direction": "either"}, (9.0, 0.0, 1.5))))
    assert either.duration == pytest.approx(forward.duration, rel=0.03)


def test_a_mirrored_track_takes_as_long():
    race = RACES["in line"]
    across = np.array([1.0, -1.0, 1.0])
    gates = [gate.model_copy(update={"position": tuple(gate.position * across), "yaw": -(gate.yaw or 0.0)}) for gate in race.track.gates]
    mirrored = race.model_copy(update={"track": race.track.model_copy(update={"gates": tuple(gates)})})
    assert find_plan(Problem.of(mirrored)).duration == pytest.approx(planned("in line")[2].duration, rel=2e-3)


def test_the_cache_tells_tracks_apart_by_what_stands_on_them():
    problem = Problem.of(RACES["obstacles in line"])
    assert problem.course is not None
    renamed = dataclasses.replace(problem, course=problem.course.model_copy(update={"name": "other"}))
    moved = dataclasses.replace(problem, course=problem.course.model_copy(update={"poles": ()}))
    assert key(renamed) == key(problem) != key(moved)
