"""Files as people bring them: what was wrong with each is said, or flown as it should be.

Numbers of drones and tracks are those of public files: learnsyslab/drone-models, level 0 of lsy_drone_racing, RotorPy's Crazyflie.
"""

from __future__ import annotations

import numpy as np
import pytest

import hotlap as api
from hotlap.core.errors import PlanningError
from hotlap.feasibility import Level, describe
from hotlap.files.descriptions import load, load_race
from hotlap.planning.planner import find_plan
from hotlap.planning.preparation import prepare
from hotlap.planning.problem import Problem

CRAZYFLIE = """
mass = 0.03
inertia = {inertia}
arm = 0.043
rotor_thrust = {rotor_thrust}
torque_ratio = 0.00594
{more}
"""

REFUSED = {
    "degrees in a yaw": (
        "start = [0.0, 0.0, 1.0]\ngates = [{ position = [3.0, 0.0, 1.0], yaw = -90.0 }]",
        "gates[0].yaw: -90 rad is more than a full turn; angles are in radians (did you mean -1.571?)",
    ),
    "latitude and longitude": (
        "start = [47.38, 8.54, 1.0]\ngates = [[47.38001, 8.54, 1.0], [47.38001, 8.54001, 1.0]]",
        "gates: the whole track is 2e-05 m long; coordinates are in metres, not in degrees",
    ),
    "one thrust in place of two": (
        CRAZYFLIE.format(inertia=[1.4e-5, 1.4e-5, 2.2e-5], rotor_thrust=0.15, more=""),
        "rotor_thrust: must be a list in brackets, not 0.15: [N] least and largest thrust of one rotor",
    ),
    "two values in place of three": (
        CRAZYFLIE.format(inertia=[1.4e-5, 2.2e-5], rotor_thrust=[0.0, 0.15], more=""),
        "inertia: must have 3 values, not 2: [kg m^2] (body) principal moments",
    ),
    "moments that no body has": (
        CRAZYFLIE.format(inertia=[1.4e-5, 1.4e-5, 3.5e-5], rotor_thrust=[0.0, 0.15], more=""),
        "inertia: no body has [1.4e-05, 1.4e-05, 3.5e-05]: the largest moment exceeds the sum of the other two",
    ),
    "a misspelt key beside a base": (
        'base = "kite.toml"\nmas = 1.0',
        "mas: there is no such key (did you mean mass?); available: name, mass,",
    ),
    "a misspelt key alone": (
        "mas = 1.0",
        "is neither a race (it has a track), a track (gates) nor a quadrotor (mass); there is no key mas",
    ),
    "a base that is not there": (
        'base = "hummingbrid"\nmas = 1.0',
        "base: there is no race, track or quadrotor named 'hummingbrid' (did you mean",
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_cannot_be_meant_is_refused_in_one_line_that_says_what_would_be(hotlap, here, what):
    text, reason = REFUSED[what]
    (here / "kite.toml").write_text('base = "hummingbird"\n')
    (here / "mine.toml").write_text(text)
    ran = hotlap("check", "mine.toml")
    assert (ran.code, ran.out, ran.err.count("\n")) == (2, "", 1)
    assert ran.err.startswith(f"hotlap: mine.toml: {reason}")


LEVEL_0 = """vehicle = "hummingbird"
[track]
start = [-1.5, 0.75, 0.05]
gates = [[0.5, 0.25, 0.7], [1.05, 0.75, 1.2], [-1.0, -0.25, 0.7], [0.0, -0.75, 1.2]]
"""
NOTED = {
    "heights of a frame whose z points down": (
        "start = [0.0, 0.0, -1.0]\ngates = [[3.0, 0.0, -2.0], [6.0, 0.0, -1.5]]",
        ("height", Level.NOTE, "z is up here; in NED files it is down"),
    ),
    "moments that were measured": (
        CRAZYFLIE.format(inertia=[1.43e-5, 1.43e-5, 2.89e-5], rotor_thrust=[0.0, 0.15], more=""),
        ("inertia", Level.NOTE, "exceeds the sum of the other two"),
    ),
    "motors without lag": (
        CRAZYFLIE.format(inertia=[1.4e-5, 1.4e-5, 2.2e-5], rotor_thrust=[0.0, 0.15], more="motor_time = [0.0, 0.0]"),
        ("rate loop damping", Level.FACT, "the motors follow at once"),
    ),
    "slow motors": (
        CRAZYFLIE.format(inertia=[1.4e-5, 1.4e-5, 2.2e-5], rotor_thrust=[0.0, 0.15], more="motor_time = [0.065, 0.065]"),
        ("lag", Level.NOTE, "which no controller's model has"),
    ),
    "a slow rate loop": (
        CRAZYFLIE.format(inertia=[3.3e-5, 3.6e-5, 5.9e-5], rotor_thrust=[0.0, 0.39], more="rate_gain = [5.27, 5.27, 5.27]"),
        ("lag", Level.NOTE, "which no controller's model has"),
    ),
    "points that are degrees": (
        "start = [0.0, 0.0, 1.0]\ngates = [[47.38, 8.54, 1.0], [47.3801, 8.54, 1.0]]",
        ("closest points", Level.NOTE, "gate 1 and gate 2; coordinates are in metres, not in degrees"),
    ),
    "gates within reach of one place": (
        LEVEL_0,
        ("gates are close", Level.WARNING, "from gate 1 to gate 2, where 1.3 m count"),
    ),
    "a judge that counts less than the plan keeps to": (
        'track = "circle"\nvehicle = "hummingbird"\njudge = { distance = 0.15 }',
        ("judge.distance", Level.WARNING, "raise judge.distance or lower planning.tolerance"),
    ),
}


@pytest.mark.parametrize("what", NOTED)
def test_what_may_be_meant_is_said(tmp_path, what):
    text, (label, level, remark) = NOTED[what]
    (tmp_path / "mine.toml").write_text(text)
    found = next(finding for finding in describe(load(tmp_path / "mine.toml")) if finding.label == label)
    assert found.level is level
    assert remark in found.remark


def make_race(folder, track, vehicle, more=""):
    """A race of one's own, written as people write it."""
    (folder / "mine.toml").write_text(f"track = {{ {track} }}\nvehicle = {vehicle}\n{more}")
    return load_race(folder / "mine.toml")


def findings(race, **options):
    return {finding.label: finding for finding in api.check(race, **options).findings}


TWO_GATES = "start = [0.0, 0.0, 2.0], gates = [[8.0, 0.0, 2.0], [14.0, 4.0, 2.0]]"


def test_a_drone_that_starts_on_the_ground_stands_on_it(tmp_path):
    race = make_race(tmp_path, "start = [0.0, 0.0, 0.01], floor = 0.0, gates = [[3.0, 0.0, 1.0], [6.0, 2.0, 1.0]]", '"split-s-racer"')
    found = findings(race)
    assert found["default weights"].value == "50 of 50 flights complete"
    assert found["difficulty"].value == "easy"


@pytest.mark.check
def test_a_plan_knows_every_drag_of_its_vehicle(tmp_path):
    race = make_race(tmp_path, "start = [0.0, 0.0, 2.0], gates = [[50.0, 0.0, 2.0], [100.0, 0.0, 2.0]]", '"airsim"', "planning.nodes = 8")
    assert prepare(race).reference.max_speed < 23.1, "its top speed in level flight"
    found = findings(race)
    assert found["default weights"].value == "50 of 50 flights complete"
    assert not [finding for finding in found.values() if finding.level is Level.WARNING]


@pytest.mark.check
def test_what_a_slow_rate_loop_does_is_flown_and_never_called_easy(tmp_path):
    found = findings(make_race(tmp_path, TWO_GATES, '{ base = "hummingbird", rate_gain = [2.0, 2.0, 2.0] }'))
    assert found["difficulty"].value != "easy"
    assert found["default weights"].level is Level.NOTE
    assert (found["lag"].value, found["lag"].level) == ("525 ms", Level.NOTE)


FIVE_INCH = """{ mass = 0.65, inertia = [2.5e-3, 2.2e-3, 4.3e-3], arm = 0.11, rotor_thrust = [0.1, 11.0], torque_ratio = 0.016,
    motor_time = [0.025, 0.035], drag = [0.3, 0.3, 0.1], rate_gain = [22.0, 22.0, 8.0], delay = 0.02 }""".replace("\n", "")


def test_a_plans_first_moment_can_be_followed(tmp_path):
    race = make_race(tmp_path, TWO_GATES, '"hummingbird"')
    reference = prepare(race).reference
    hover = race.vehicle.gravity
    np.testing.assert_allclose(reference.rates[0], 0.0, atol=1e-6)
    assert reference.thrust[0] == pytest.approx(hover, rel=0.02)
    assert findings(race, flights=0)["first moment"].level is Level.FACT


def test_a_plan_passes_gates_in_their_direction_whatever_the_rule(tmp_path):
    gates = "start = [0.0, 0.0, 2.0], gates = [{ position = [6.0, 0.0, 2.0], yaw = 0.0 }, { position = [12.0, 0.0, 2.0], yaw = 3.1 }]"
    more = '[judge]\nrule = "clock"\n[planning]\ndynamics = "ideal"'
    assert "passed backwards" not in findings(make_race(tmp_path, gates, '"split-s-racer"', more), flights=0)


def test_a_gate_below_the_floor_of_the_plan_is_counted_from_1(tmp_path):
    track = "start = [0.0, 0.0, 2.0], gates = [[6.0, 0.0, 2.0], [12.0, 0.0, 0.5]]"
    race = make_race(tmp_path, track, '"split-s-racer"', "planning.floor = 1.5")
    with pytest.raises(PlanningError, match="gate 2"):
        find_plan(Problem.of(race))


YARD = """start = [0.0, 0.0, 1.0], floor = 0.0, gates = [[5.0, 1.0, 1.5], [10.0, 4.0, 1.5], [12.0, 9.0, 2.0], [8.0, 13.0, 2.5],
    [2.0, 12.0, 1.5], [-2.0, 7.0, 1.5], [0.0, 2.0, 1.2]]""".replace("\n", "")


@pytest.mark.check
def test_a_drone_and_a_track_of_ones_own_are_easy_as_they_are_planned_by_default(tmp_path):
    found = findings(make_race(tmp_path, YARD, FIVE_INCH, "[judge]\ndistance = 0.5\n[planning]\ntolerance = 0.1"))
    assert found["difficulty"].value == "easy"
    assert found["controller limits"].value == "wide enough"
