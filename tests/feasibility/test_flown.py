"""What a plan, or a reference in its place, asks for, and how it passes the gates: told from references that are made by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hotlap.feasibility.finding import Level
from hotlap.feasibility.flown import describe_flown, rooms
from hotlap.files.descriptions import load_quadrotor
from hotlap.race.gate import Gate, PassingDirection
from hotlap.race.obstacles import Pole
from hotlap.race.race import GateRule, JudgeSettings, PlanningSettings, Race
from hotlap.race.track import Track
from hotlap.reference.reference import Reference

SPEED = 2.0  # m/s along x


def straight(gates, rates=0.0):
    """Level flight along x that passes x = 2, 4, ... m one second after the other."""
    rows = 100 * (gates + 1) + 1
    position, velocity, turning = np.zeros((rows, 3)), np.zeros((rows, 3)), np.zeros((rows, 3))
    position[:, 0], position[:, 2], velocity[:, 0], turning[0, 1] = 0.01 * SPEED * np.arange(rows), 1.0, SPEED, rates
    attitude, rotors = np.tile([1.0, 0.0, 0.0, 0.0], (rows, 1)), np.full((rows, 4), 2.0)
    times = np.arange(1.0, gates + 1)
    return Reference(position, attitude, velocity, turning, np.full(rows, 9.81), rotors, times, duration=float(gates))


def make_race(*gates, judge=None, poles=(), **planning):
    settings = {} if judge is None else {"judge": judge}
    track = Track(name="hall", start=(0.0, 0.0, 1.0), gates=gates, poles=poles)
    return Race(name="hall", track=track, vehicle=load_quadrotor("split-s-racer"), planning=PlanningSettings(**planning), **settings)


def findings(race, file="", **flown):
    reference = straight(len(race.track.counted), **flown)
    return {finding.label: finding for finding in describe_flown(race, reference, file)}


def gate(x, y=0.0, **more):
    return Gate(position=(x, y, 1.0), **more)


CLOSEST = JudgeSettings(rule=GateRule.CLOSEST)


def test_the_room_of_a_point_is_what_counts_less_how_far_it_is_passed():
    race = make_race(gate(2.0, 0.3), gate(4.0, -1.4))
    assert rooms(race, straight(2)) == pytest.approx([1.0, -0.1])
    found = findings(race)["room at the gates"]
    assert (found.value, found.level) == ("0.10 m", Level.WARNING)
    assert "gate 2" in found.remark


def test_the_room_of_an_opening_is_that_of_the_whole_vehicle():
    race = make_race(gate(2.0, 0.1, yaw=0.0, side=1.0), gate(4.0, radius=0.4), gate(6.0, 0.2, yaw=0.0))
    size = race.vehicle.outer_radius
    assert rooms(race, straight(3)) == pytest.approx([0.5 - 0.1 - size, 0.4, 1.1])
    by_distance = race.model_copy(update={"judge": CLOSEST})
    assert rooms(by_distance, straight(3)) == pytest.approx([1.2, 1.3, 1.1])


def test_a_gate_that_is_hardly_pierced_before_the_way_back_leaves_that_little_room():
    race, there = make_race(gate(2.0, yaw=0.0, side=1.0)), straight(1)
    position = there.position.copy()
    position[:, 0] = 2.04 - np.abs(position[:, 0] - 2.04)
    assert rooms(race, replace(there, position=position)) == pytest.approx([0.04])
    assert rooms(race, there)[0] > 0.1


def test_little_room_is_noted():
    assert findings(make_race(gate(2.0, 1.28)))["room at the gates"].level is Level.NOTE
    assert findings(make_race(gate(2.0)))["room at the gates"].level is Level.FACT


def test_gates_that_are_passed_backwards_or_sideways_are_named_where_the_rule_counts_them():
    race = make_race(gate(2.0, yaw=0.0), gate(4.0, yaw=3.0), gate(6.0, yaw=1.5), gate(8.0), gate(10.0, yaw=-1.4), judge=CLOSEST)
    found = findings(race)
    assert (found["passed backwards"].value, found["passed sideways"].value) == ("1 gate", "2 gates")
    assert found["passed backwards"].remark == 'gate 2; the rule "closest" counts it, "opening" would not'
    assert found["passed sideways"].remark.startswith("gate 3, gate 5;")


@pytest.mark.parametrize("direction", [PassingDirection.BACKWARD, PassingDirection.EITHER])
def test_a_gate_that_may_be_passed_backwards_is_not_named(direction):
    assert "passed backwards" not in findings(make_race(gate(2.0, yaw=3.0, direction=direction), judge=CLOSEST))


def test_a_first_moment_that_no_drone_at_rest_can_follow_is_noted():
    calm, sudden = findings(make_race(gate(2.0)))["first moment"], findings(make_race(gate(2.0)), rates=-13.9)["first moment"]
    assert (calm.level, sudden.level) == (Level.FACT, Level.NOTE)
    assert sudden.value.endswith("13.9 rad/s")
    assert "90 ms later" in sudden.remark
    ideal = findings(make_race(gate(2.0), dynamics="ideal"), rates=-13.9)["first moment"]
    assert ideal.remark.endswith('planning.dynamics = "full" plans with that')


def test_a_reference_is_said_to_be_flown_in_place_of_a_plan():
    found = findings(make_race(gate(2.0)), file="mine.csv")
    assert found["reference"].value == "mine.csv"
    assert "in place of a plan" in found["reference"].remark
    assert "reference" not in findings(make_race(gate(2.0)))


def test_what_a_reference_asks_for_beyond_the_controller_is_a_warning():
    found = findings(make_race(gate(2.0)), file="mine.csv", rates=20.0)["reference asks"]
    assert found.level is Level.WARNING


def test_what_stands_in_the_way_of_a_reference_is_a_warning():
    near, far = (Pole(position=(3.0, y), radius=0.05) for y in (0.1, 3.0))
    found = findings(make_race(gate(2.0), gate(4.0), poles=(far, near)), file="mine.csv")["touches"]
    assert (found.value, found.level) == ("pole 2", Level.WARNING)
    assert "touches" not in findings(make_race(gate(2.0), gate(4.0), poles=(far,)), file="mine.csv")
