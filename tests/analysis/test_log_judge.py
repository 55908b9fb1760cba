"""Log judge: a flight of the built-in world, read from its log, is judged as the world has judged it."""

from __future__ import annotations

import math
import re
from dataclasses import fields

import numpy as np
import pytest

from flight.scenarios import TUNED, make_race, make_scenario
from hotlap.analysis.log_frame import find_frame
from hotlap.analysis.log_judge import ending, judge_log, missing
from hotlap.api.flown import write_log
from hotlap.core.errors import InputError
from hotlap.logs.flight_log import FlightLog, Signal
from hotlap.logs.frames import from_angles
from hotlap.logs.readers import read
from hotlap.race.race import GateRule
from hotlap.tuning.scoring import score
from hotlap.worlds.built_in import BuiltIn

NOISE = {"thrust": 0.05, "rates": 0.2, "thrust_bias": 0.02, "position": 0.05, "velocity": 0.1, "attitude": 0.02}
EXACT = {"gates_passed", "end", "cause", "cause_index"}
MEASURED = {"end_time", "end_position", "lap_time", "clock_distance", "closest_distance", "closest_time", "rim_distance"}
SEED = 3


def fly(scenario):
    """One flight, recorded in full."""
    return BuiltIn().fly(scenario, np.tile(TUNED, (1, len(scenario.segments), 1)), np.array([SEED]), log=[0])


def logged(flights, *, yaw=0.0, shift=(0.0, 0.0, 0.0), begin=0.0, hover=0.0, signals=("position", "velocity", "attitude", "rates")):
    """The log of a flight as another program would have it: in a frame and with a clock of its own, after a while of waiting."""
    record = flights.logs[0]
    c, s = math.cos(yaw), math.sin(yaw)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    turned = from_angles([0.0], [0.0], [yaw])[0]
    w, x, y, z = record.states[:, 3:7].T
    attitude = np.column_stack([turned[0] * w - turned[3] * z, turned[0] * x - turned[3] * y])
    attitude = np.column_stack([attitude, turned[0] * y + turned[3] * x, turned[0] * z + turned[3] * w])
    values = {
        "position": record.states[:, :3] @ turn.T + shift,
        "velocity": record.states[:, 7:10] @ turn.T,
        "attitude": attitude,
        "rates": record.states[:, 10:13],
    }
    waiting = np.arange(0.0, hover, 0.02)
    times = np.concatenate([begin + waiting, begin + hover + record.times])
    taken = {}
    for name in signals:
        before = np.repeat(values[name][:1] * (name in {"position", "attitude"}), len(waiting), axis=0)
        taken[name] = Signal(times, np.concatenate([before, values[name]]))
    return FlightLog("flight.ulg", "a ULog of PX4", taken)


@pytest.mark.parametrize("rule", GateRule)
@pytest.mark.parametrize("load", [1.0, 2.0])
def test_a_flight_from_its_log_has_the_verdict_of_the_world(tmp_path, rule, load):
    scenario = make_scenario({"mass": load * make_race().vehicle.mass}, noise=NOISE, judge={"rule": rule})
    flown = fly(scenario)
    write_log(tmp_path / "log.csv", flown.logs[0])
    log = read(tmp_path / "log.csv")
    judged = judge_log(log, scenario, find_frame(log, scenario))
    for name in EXACT:
        assert getattr(judged, name).tolist() == getattr(flown, name).tolist(), name
    for name in MEASURED:
        np.testing.assert_allclose(getattr(judged, name), getattr(flown, name), atol=1e-4, err_msg=name)
    mine, world = score(judged, scenario.race.judge), score(flown, scenario.race.judge)
    for field in fields(mine):
        np.testing.assert_allclose(getattr(mine, field.name), getattr(world, field.name), atol=1e-3, err_msg=field.name)
    assert mine.complete[0] == (load == 1.0)
    assert ending(scenario, judged, log, find_frame(log, scenario))
    np.testing.assert_allclose(judged.logs[0].commands[1:-1], flown.logs[0].commands[1 : len(judged.logs[0].times) - 1], atol=1e-9)


@pytest.fixture(scope="module")
def scenario():
    return make_scenario(noise=NOISE)


@pytest.fixture(scope="module")
def flown(scenario):
    return fly(scenario)


def test_the_start_is_found_after_a_while_of_waiting(scenario, flown):
    log = logged(flown, begin=100.0, hover=4.0)
    frame = find_frame(log, scenario)
    assert frame.start == pytest.approx(104.0, abs=0.1)
    assert frame.yaw == 0
    given = find_frame(log, scenario, start=104.0)
    assert judge_log(log, scenario, given).mean_error == pytest.approx(flown.mean_error, abs=2e-3)


def test_a_turned_and_shifted_log_is_laid_over_the_reference(scenario, flown):
    log = logged(flown, yaw=2.0, shift=(30.0, -7.0, 5.0), begin=50.0, hover=3.0)
    frame = find_frame(log, scenario, align=True)
    assert frame.yaw == pytest.approx(-2.0, abs=0.05)
    assert frame.start == pytest.approx(53.0, abs=0.1)
    assert frame.residual < 0.3
    judged = judge_log(log, scenario, frame)
    assert judged.gates_passed == flown.gates_passed
    assert judged.mean_error == pytest.approx(flown.mean_error, abs=0.05)
    assert "where it waited is the start" in frame.words
    np.testing.assert_allclose(np.linalg.norm(judged.logs[0].states[:, 3:7], axis=1), 1)
    apart = np.abs((judged.logs[0].states[:50, 3:7] * flown.logs[0].states[:50, 3:7]).sum(axis=1))
    assert apart.min() > 0.99


def test_who_is_late_stays_late_when_laid_over_the_reference():
    scenario = make_scenario({"rotor_drag": 0.05}, controller={"feed_forward": False})
    flown = fly(scenario)
    log = logged(flown, yaw=-1.0, shift=(3.0, 2.0, 1.0), begin=9.0, hover=2.0)
    judged = judge_log(log, scenario, find_frame(log, scenario, align=True))
    assert flown.mean_error > 0.1
    assert judged.mean_error == pytest.approx(flown.mean_error, rel=0.5)


def test_a_log_that_begins_in_flight_is_laid_over_the_clocked_reference(scenario, flown):
    log = logged(flown, yaw=1.0)
    late = {name: Signal(signal.times[30:], signal.values[30:]) for name, signal in log.signals.items()}
    frame = find_frame(FlightLog("a", "b", late), scenario, align=True)
    assert frame.yaw == pytest.approx(-1.0, abs=0.2)


def test_a_log_of_another_frame_is_asked_about_in_one_line(scenario, flown):
    with pytest.raises(
        InputError, match=r"comes no nearer than \d+.\d m to the start of .*align=... lays it over.*start=... says when"
    ) as told:
        find_frame(logged(flown, shift=(30.0, 0.0, 0.0)), scenario)
    assert "\n" not in str(told.value)


def test_a_drone_that_stays_at_the_start_has_not_flown(scenario):
    place = scenario.reference.position[:1]
    log = FlightLog("a.csv", "a CSV table", {"position": Signal(np.arange(9.0), np.repeat(place, 9, axis=0))})
    with pytest.raises(InputError, match="never leaves the start"):
        find_frame(log, scenario)
    with pytest.raises(InputError, match="no shift and turn lay it over"):
        find_frame(log, scenario, align=True)


@pytest.mark.parametrize("start", [-1.0, 99.0])
def test_a_start_beyond_the_log_is_refused(scenario, flown, start):
    with pytest.raises(InputError, match=r"start: must be from 0.00 to \d.\d\d s"):
        find_frame(logged(flown), scenario, start=start)


def test_a_log_that_ends_too_early_says_so(scenario, flown):
    log = logged(flown)
    short = {name: Signal(signal.times[:150], signal.values[:150]) for name, signal in log.signals.items()}
    cut = FlightLog("a", "b", short)
    frame = find_frame(cut, scenario, start=0.0)
    judged = judge_log(cut, scenario, frame)
    assert not score(judged, scenario.race.judge).complete[0]
    assert ending(scenario, judged, cut, frame).startswith("the log ends 1.4")


def test_positions_alone_are_enough(scenario, flown):
    log = logged(flown, signals=("position",))
    judged = judge_log(log, scenario, find_frame(log, scenario, start=0.0))
    assert judged.gates_passed == flown.gates_passed
    assert judged.mean_error == pytest.approx(flown.mean_error, abs=1e-3)
    assert np.isfinite(judged.logs[0].states).all()
    assert len(list(missing(log, find_frame(log, scenario, start=0.0)))) == 4


def without(log, begin, end):
    """A log without positions between two times."""
    position = log.signals["position"]
    kept = (position.times <= begin) | (position.times >= end)
    return FlightLog(log.name, log.kind, {**log.signals, "position": Signal(position.times[kept], position.values[kept])})


@pytest.mark.parametrize("rule", GateRule)
def test_a_gate_in_a_gap_was_not_seen(rule):
    scenario = make_scenario(noise=NOISE, judge={"rule": rule})
    flown = fly(scenario)
    assert flown.gates_passed[0] == 5
    passed = flown.gate_times[2] if rule is GateRule.CLOCK else flown.closest_time[0, 2]
    log = without(logged(flown), passed - 0.2, passed + 0.2)
    frame = find_frame(log, scenario, start=0.0)
    judged = judge_log(log, scenario, frame)
    assert judged.gates_passed[0] == 2
    assert judged.end_time[0] < passed
    told = ending(scenario, judged, log, frame)
    assert re.fullmatch(r"was not seen from \d\.\d\d to \d\.\d\d s after the start, where gate 3 was: the log has no positions there", told)
    assert any(note.startswith("position: no sample from ") for note in missing(log, frame))


def test_a_gap_without_a_gate_is_noted_and_drawn_as_a_straight_line(scenario, flown):
    middle = (flown.gate_times[1] + flown.gate_times[2]) / 2
    log = without(logged(flown), middle - 0.13, middle + 0.13)
    frame = find_frame(log, scenario, start=0.0)
    judged = judge_log(log, scenario, frame)
    assert judged.gates_passed == flown.gates_passed
    assert [note for note in missing(log, frame) if note.startswith("position: no sample from ")]
