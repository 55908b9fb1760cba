"""What a race means before it is planned: what counts at its gates, and what its controller does not know."""

from __future__ import annotations

import math

import pytest

from hotlap.feasibility.finding import Level
from hotlap.feasibility.race import describe_race, lag, loose_judge
from hotlap.files.descriptions import load_quadrotor, load_race
from hotlap.race.gate import Gate
from hotlap.race.race import GateRule, JudgeSettings, PlanDynamics, PlanningSettings, Race
from hotlap.race.track import Track


def make_race(gates, judge=None, **planning):
    """A drone of the built-in ones on gates of one's own."""
    track = Track(name="hall", start=(0.0, 0.0, 1.0), gates=tuple(gates))
    settings = {} if judge is None else {"judge": judge}
    return Race(name="hall", track=track, vehicle=load_quadrotor("split-s-racer"), planning=PlanningSettings(**planning), **settings)


def points(*places, **more):
    return [Gate(position=place, **more) for place in places]


def findings(race, **options):
    return {finding.label: finding for finding in describe_race(race, **options)}


FAR_APART = points((4.0, 0.0, 1.0), (8.0, 3.0, 1.0), (12.0, 0.0, 1.0))


def test_gates_that_one_place_passes_both_are_warned_of():
    near = [*FAR_APART, *points((4.0, 2.0, 1.0))]
    found = findings(make_race(near))["gates are close"]
    assert (found.value, found.level) == ("2.00 m", Level.WARNING)
    assert found.remark.startswith("from gate 1 to gate 4, where 1.3 m count")
    assert "gates are close" not in findings(make_race(near, JudgeSettings(distance=0.99)))
    assert "gates are close" not in findings(make_race(FAR_APART))


def test_a_gate_that_is_flown_twice_is_not_close_to_itself():
    assert "gates are close" not in findings(make_race([*FAR_APART, FAR_APART[0]]))


def test_openings_decide_by_themselves_how_close_gates_may_be():
    near = points((4.0, 0.0, 1.0), (4.0, 1.5, 1.0), yaw=0.0, side=1.0)
    assert "gates are close" not in findings(make_race(near))
    assert "gates are close" in findings(make_race(near, JudgeSettings(rule=GateRule.CLOSEST)))


def test_a_judge_that_counts_no_more_than_the_plan_keeps_to_is_warned_of():
    loose = JudgeSettings(distance=0.15)
    found = findings(make_race(FAR_APART, loose))["judge.distance"]
    assert found.level is Level.WARNING
    assert found.remark.endswith("raise judge.distance or lower planning.tolerance")
    assert loose_judge(make_race(FAR_APART, loose)) == found.remark
    assert loose_judge(make_race(FAR_APART, loose, tolerance=0.1)) == ""
    assert loose_judge(make_race(points((4.0, 0.0, 1.0), yaw=0.0, side=1.0), loose)) == "", "its opening decides"


def test_what_a_reference_stands_in_for_is_not_said():
    loose = make_race(FAR_APART, JudgeSettings(distance=0.15))
    assert {"plan", "plan uses", "judge.distance"} & set(findings(loose, planned=False)) == set()


@pytest.mark.parametrize(
    ("gates", "said"),
    [
        (FAR_APART, "within 1.3 m of each gate at the reference's time"),
        (points((4.0, 0.0, 1.0), yaw=0.0, side=1.0), "gates in their order: 1 through their openings with all of the vehicle"),
        ([*points((4.0, 0.0, 1.0), yaw=0.0, side=1.0), *FAR_APART[1:]], "all of the vehicle, 2 within 1.3 m"),
        ([*points((4.0, 0.0, 1.0), radius=0.5), *points((8.0, 0.0, 1.0), yaw=0.0)], "1 within their radius, 1 within 1.3 m"),
    ],
)
def test_what_counts_as_passing_a_gate_is_said_in_words(gates, said):
    assert findings(make_race(gates))["judged by"].remark.endswith(said)


def test_rates_that_follow_late_are_noted_and_the_built_in_drones_are_quick():
    quick = load_quadrotor("hummingbird")
    assert lag(quick).level is Level.FACT
    slow_loop = quick.model_copy(update={"rate_gain": (0.5, 20.0, 8.0)})
    slow_motors = quick.model_copy(update={"motor_time": (0.065, 0.02)})
    assert (lag(slow_loop).level, lag(slow_motors).level) == (Level.NOTE, Level.NOTE)
    assert lag(slow_loop).value == f"{1e3 * (1 / 0.5 + max(quick.motor_time)):.0f} ms"
    assert describe_race(load_race("circle-34").model_copy(update={"vehicle": slow_loop}))


def test_steady_flight_of_a_plan_that_knows_all_drags_takes_what_the_plan_may_use():
    gates = points((60.0, 0.0, 1.0), (460.0, 0.0, 1.0))
    race = make_race(gates).model_copy(update={"vehicle": load_quadrotor("airsim")})
    assert findings(race)["steady flight takes"].value == findings(race)["plan uses"].value
    ideal = race.model_copy(update={"planning": PlanningSettings(dynamics=PlanDynamics.IDEAL, v_max=30.0)})
    assert findings(ideal)["steady flight takes"].level is Level.WARNING


def test_a_plan_that_knows_all_drags_keeps_below_the_top_speed():
    race = make_race(points((60.0, 0.0, 1.0), (160.0, 0.0, 1.0))).model_copy(update={"vehicle": load_quadrotor("airsim")})
    speed = float(findings(race)["plan"].remark.split()[-2])
    assert speed < 23.1
    assert math.isfinite(speed)
