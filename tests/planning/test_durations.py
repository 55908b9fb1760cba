"""Plans take as long as the authors' own, with their planning models, waypoints and v_max (the T of their files)."""

from __future__ import annotations

import math

import pytest

from hotlap.files.descriptions import load_race
from hotlap.planning import plan
from hotlap.race.race import Race
from hotlap.race.track import Gate

from . import small

AUTHORS = [
    ("circle-34", 34, 8.648),
    ("flip-16", 16, 14.550),
    pytest.param("spiral-53", 48, 17.954, marks=pytest.mark.check),
    ("drop-20", 20, 12.697),
    pytest.param("qualifier-20", 19, 24.107, marks=pytest.mark.check),
    pytest.param("spiral20-53", 48, 33.028, marks=pytest.mark.check),
    pytest.param("split-s", None, 20.113, marks=pytest.mark.check),
]


def at_speed(race: Race, v_max: float | None) -> Race:
    return race.model_copy(update={"planning": race.planning.model_copy(update={"v_max": v_max})})


@pytest.mark.parametrize(("name", "v_max", "duration"), AUTHORS)
def test_a_plan_takes_as_long_as_the_authors(name, v_max, duration):
    assert plan(at_speed(load_race(name), v_max), cache=False).duration == pytest.approx(duration, rel=2e-3)


@pytest.mark.slow
def test_soccer_medium_takes_as_long_as_the_authors_through_their_extra_waypoint():
    race = load_race("soccer-medium-20")
    gates = list(race.track.gates)
    gates.insert(20, Gate(position=(109.7, 25.07, -15.35)))
    race = race.model_copy(update={"track": race.track.model_copy(update={"gates": tuple(gates)})})
    assert plan(race, cache=False).duration == pytest.approx(31.406, rel=2e-3)


@pytest.mark.slow
def test_the_reconstructed_final_takes_as_long_as_measured_before():
    assert plan(load_race("final-22"), cache=False).duration == pytest.approx(36.67, rel=1e-2)


def test_a_climb_takes_as_long_as_full_thrust_needs():
    race = small.make_race([(0.0, 0.0, 20.5)], planning={"v_max": None})
    acceleration = race.planning_model.max_acceleration - race.planning_model.gravity
    assert plan(race, cache=False).duration == pytest.approx(math.sqrt(2 * 19.8 / acceleration), rel=1e-3)


def test_more_thrust_and_more_tolerance_are_faster_and_drag_is_slower():
    usual = small.planned("drag")[3].duration
    end = {"end": (-6.0, 0.0, 0.8)}
    for faster in (
        small.make_race(track=end, quadrotor={"rotor_thrust": (0.0, 5.0)}),
        small.make_race(track=end, planning={"tolerance": 0.4}),
    ):
        assert plan(faster, cache=False).duration < usual
    assert plan(small.make_race(track=end, planning={"v_max": 12.0}), cache=False).duration > usual


def test_turning_and_moving_the_track_changes_no_duration():
    def turned(point):
        return (-point[1] + 7.0, point[0] - 3.0, point[2] + 1.0)

    race, half = small.RACES["inverted"], math.sqrt(0.5)
    track = {"start": turned(race.track.start), "attitude": (0.0, half, half, 0.0)}  # a quarter turn to the left
    moved = race.model_copy(update={"track": small.make_race([turned(gate) for gate in small.HILL], track=track).track})
    assert plan(moved, cache=False).duration == pytest.approx(small.planned("inverted")[3].duration, rel=1e-3)
