"""A whole flight over a link without any protocol, and everything that stops one."""

from __future__ import annotations

import dataclasses
import re
import threading
import time

import numpy as np
import pytest

from hotlap.analysis.log_frame import find_frame
from hotlap.analysis.log_judge import judge_log
from hotlap.api.flown import write_log
from hotlap.core.errors import InputError
from hotlap.core.records import End
from hotlap.logs.hotlap_csv import read_hotlap_csv
from hotlap.real_flight import flight as flight_loop
from hotlap.real_flight import speaker, stream
from hotlap.real_flight.flight import RealFlight
from hotlap.real_flight.guard import Reason
from hotlap.real_flight.link import LinkError, Request
from hotlap.real_flight.settings import FlightSettings, Phase
from hotlap.real_flight.stand_in import Mode
from real_flight.hangar import DirectLink, PuppetLink, make_drone, make_scenario

SCENARIO = make_scenario()
PARAMETERS = SCENARIO.space.first_guess(1)
WITHIN = 0.5  # s


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """A stop is asked for without waiting in wall time, which the drone of these tests does not have; and nobody waits for long."""
    monkeypatch.setattr(stream, "STOPPING", 0.05)
    for name, short in {"MEETING": 0.2, "IDLE": 0.2, "STEADY_FOR": 1.0}.items():
        monkeypatch.setattr(flight_loop, name, short)


def flight(link, **settings):
    return RealFlight(link, SCENARIO, PARAMETERS, FlightSettings(**settings))


def airborne(**drone):
    """A drone that hovers at the start by itself."""
    made = make_drone(SCENARIO, **drone)
    made.hover(SCENARIO.reference.position[0])
    return made


def in_race(link, act, after=0.3):
    """Let something happen so many seconds after the race has begun; gives a list with when it did."""
    begun, happened = [], []

    def script(each):
        if not begun and each.sent and each.sent[-1][1].race_time is not None:
            begun.append(each.sent[-1][0])
        if not happened and begun and each.drone.time >= begun[0] + after:
            happened.append(each.drone.time)
            act(each)

    link._script = script
    return happened


@pytest.mark.parametrize("share", [0.85, pytest.param(1.15, marks=pytest.mark.check)])
def test_it_takes_off_hovers_at_the_right_height_passes_every_gate_and_lands(share, tmp_path):
    drone = make_drone(SCENARIO, share)
    heights = []
    link = DirectLink(drone, lambda each: heights.append((each.drone.time, each.drone.state[2])))
    flown = flight(link, arm=True).fly()
    assert (flown.halt, flown.phase, drone.crashed, drone.armed, link.closed) == (None, Phase.LAND, False, False, True)
    begun = flown.record.race_begun
    hovering = np.array([height for moment, height in heights if begun - 1 <= moment <= begun])
    assert np.abs(hovering - SCENARIO.reference.position[0, 2]).max() < 0.05
    assert flown.gain == pytest.approx(share, rel=0.01)
    landing = next(moment for moment, request in link.requests if request is Request.LAND)
    assert max(moment for moment, _, _ in link.sent) <= landing + 0.05
    path = tmp_path / "flight.csv"
    write_log(path, flown.record.log(4))
    log = read_hotlap_csv(path)
    judged = judge_log(log, SCENARIO, find_frame(log, SCENARIO))
    assert (judged.end[0], judged.gates_passed[0]) == (End.FINISHED, 3)


@pytest.mark.parametrize(("what", "request_"), [("states", Request.LAND), ("speaks", Request.HOLD), ("clock", Request.DISARM)])
def test_without_states_it_is_stopped_within_half_a_second_and_nothing_is_sent_any_more(what, request_):
    link = DirectLink(airborne())
    link.follows = what == "clock"
    cut = in_race(link, lambda each: setattr(each, "speaks" if what == "clock" else what, False))
    flown = flight(link, on_stop=request_).fly()
    assert flown.halt.reason is (Reason.LINK if what == "clock" else Reason.STALE)
    stopped = next(moment for moment, request in link.requests if request is request_)
    assert cut[0] < stopped <= cut[0] + WITHIN
    assert max(moment for moment, _, _ in link.sent) <= cut[0]


def test_ctrl_c_stops_it_and_is_heard_of():
    def interrupt(_):
        raise KeyboardInterrupt

    link = DirectLink(airborne())
    cut = in_race(link, interrupt, 0.2)
    flying = flight(link)
    with pytest.raises(KeyboardInterrupt):
        flying.fly()
    assert link.requests[-1][1] is Request.LAND
    assert link.requests[-1][0] <= cut[0] + WITHIN
    assert max(moment for moment, _, _ in link.sent) <= cut[0]
    assert len(flying.stream.record.seen) > 100


def test_a_fault_of_hotlap_itself_stops_it_too():
    def fail(_):
        raise ZeroDivisionError

    link = DirectLink(airborne())
    in_race(link, fail, 0.2)
    with pytest.raises(ZeroDivisionError):
        flight(link).fly()
    assert link.requests[-1][1] is Request.LAND


def test_nothing_is_sent_outside_of_the_geofence():
    link = DirectLink(airborne())
    in_race(link, lambda each: setattr(each.drone, "thrust_share", 0.2), 0.3)
    flown = flight(link, margin=0.4).fly()
    assert flown.halt.reason is Reason.FENCE
    assert not any(flown.geofence.outside(state[:3]) for _, _, state in link.sent)
    assert flown.geofence.outside(np.array([0.0, 0.0, 0.5]))


def test_who_takes_over_is_left_alone():
    link = DirectLink(airborne())
    cut = in_race(link, lambda each: each.drone.change(Mode.HOLD), 0.2)
    flown = flight(link).fly()
    assert flown.halt.reason is Reason.TAKEN_OVER
    assert [request for _, request in link.requests] == [Request.ENGAGE]
    assert max(moment for moment, _, _ in link.sent) <= cut[0]


@pytest.mark.parametrize("way", ["slow", "interrupted", "no number"])
def test_who_takes_over_while_it_lands_is_left_alone_however_that_ends(way, monkeypatch):
    monkeypatch.setattr(flight_loop, "LANDING", 1.0)

    def take_over(each):
        asked = next((at for at, request in each.requests if request is Request.LAND), np.inf)
        if each.drone.time > asked:
            each.drone.change(Mode.HOLD)
        if each.drone.time > asked + 0.1:
            each.shift = np.full(3, np.nan if way == "no number" else 0.0)
            if way == "interrupted":
                raise KeyboardInterrupt

    link = DirectLink(airborne(), take_over)
    flying = flight(link, on_stop=Request.DISARM)
    if way == "interrupted":
        with pytest.raises(KeyboardInterrupt):
            flying.fly()
    else:
        assert flying.fly().halt is not None
    assert (flying.phase, flying.asked_to) == (Phase.LAND, None)
    assert [request for _, request in link.requests] == [Request.ENGAGE, Request.LAND]


def test_who_takes_over_because_the_position_fails_is_left_alone():
    link, said = DirectLink(airborne()), []
    in_race(link, lambda each: (each.drone.change(Mode.HOLD), setattr(each, "shift", np.full(3, np.nan))), 0.2)
    flown = RealFlight(link, SCENARIO, PARAMETERS, FlightSettings(), said.append).fly()
    assert (flown.halt.reason, link.requests[-1][1]) == (Reason.TAKEN_OVER, Request.ENGAGE)


def test_a_stop_that_is_refused_is_said():
    link, said = DirectLink(airborne()), []
    in_race(link, lambda each: (setattr(each, "states", False), setattr(each, "refusal", "mode denied")), 0.2)
    RealFlight(link, SCENARIO, PARAMETERS, FlightSettings(), said.append).fly()
    assert said[-1] == "note: mode denied"


def test_a_pilot_who_does_not_hand_over_is_left_alone():
    link = DirectLink(airborne())
    link.drone.change = lambda mode: False
    link.refusal = "mode denied"
    flown = flight(link).fly()
    assert (flown.phase, flown.halt.reason) == (Phase.ENGAGE, Reason.REFUSED)
    assert {request for _, request in link.requests} == {Request.ENGAGE}


def test_an_interruption_after_it_was_asked_to_follow_stops_it_before_it_says_so():
    def interrupt(each):
        if each.requests:
            raise KeyboardInterrupt

    link = DirectLink(airborne(), interrupt)
    with pytest.raises(KeyboardInterrupt):
        flight(link).fly()
    assert [request for _, request in link.requests] == [Request.ENGAGE, Request.LAND]


def test_a_position_that_jumps_stops_it():
    link = DirectLink(airborne())
    in_race(link, lambda each: setattr(each, "shift", np.array([1.2, 0.0, 0.0])), 0.2)
    assert flight(link).fly().halt.reason is Reason.JUMP


@pytest.mark.parametrize("frozen", [slice(0, 3), slice(0, 13)], ids=["the position", "the whole state"])
def test_an_estimate_that_freezes_while_it_flies_stops_it(frozen):
    link = DirectLink(airborne())
    cut = in_race(link, lambda each: setattr(each, "frozen", (frozen, each.drone.state)), 1.2)
    flown = flight(link).fly()
    assert flown.halt.reason is Reason.JUMP
    assert max(moment for moment, _, _ in link.sent) <= cut[0] + 0.3
    assert link.requests[-1][1] is Request.LAND


def test_an_estimate_that_freezes_while_it_hovers_stops_it():
    link, begun = DirectLink(airborne()), []

    def freeze(each):
        if flying.phase is Phase.STAND and not begun:
            begun.append(each.drone.time)
            each.frozen = slice(0, 13), each.drone.state

    flying = flight(link)
    link._script = freeze
    flown = flying.fly()
    assert flown.halt.reason is Reason.FROZEN
    assert begun[0] + 0.5 <= max(moment for moment, _, _ in link.sent) <= begun[0] + 0.6


@pytest.mark.parametrize("leap", [0.6, 30.0])
def test_a_time_that_leaps_stops_it_before_anything_is_sent(leap):
    link, leapt = DirectLink(airborne()), [0.0]
    receive = link.receive
    link.receive = lambda wait: dataclasses.replace(seen := receive(wait), time=seen.time + leapt[0])
    cut = in_race(link, lambda _: leapt.__setitem__(0, leap), 0.3)
    flown = flight(link).fly()
    assert flown.halt.reason is Reason.TIME
    assert max(moment for moment, _, _ in link.sent) <= cut[0]


@pytest.mark.parametrize("wrong", [{"rates": np.array([0.0, np.nan, 0.0])}, {"thrust": np.nan}, {"thrust": np.inf}])
def test_a_command_that_is_no_number_is_not_sent(wrong):
    link = DirectLink(airborne())
    flying = flight(link)
    order = flying._course.race.order
    flying._course.race.order = lambda seen: dataclasses.replace(order(seen), **wrong)
    assert flying.fly().halt.reason is Reason.COMMAND
    assert all(np.isfinite([setpoint.throttle, setpoint.thrust, *setpoint.rates]).all() for _, setpoint, _ in link.sent)
    assert link.requests[-1][1] is Request.LAND


@pytest.mark.parametrize("phase", [Phase.RACE, Phase.STAND])
def test_who_is_far_from_the_reference_is_not_told_to_go_there(phase):
    link = DirectLink(airborne())
    flying = flight(link, margin=9.0)
    flying.stream.guard.check_distance, check = lambda *_: None, flying.stream.guard.check_distance
    farthest = []

    def shrink(each):
        if flying.phase is phase and not farthest:
            farthest.append(each.drone.time)
            flying.stream.guard.farthest, flying.stream.guard.check_distance = 0.0, check

    link._script = shrink
    assert flying.fly().halt.reason is Reason.STRAYED
    assert flying.phase is phase
    assert max(moment for moment, _, _ in link.sent) <= farthest[0]


def test_a_position_that_is_no_number_is_said_before_anything_is_sent():
    link = DirectLink(airborne())
    link.shift = np.full(3, np.nan)
    flown = flight(link).fly()
    assert (flown.phase, flown.halt.reason, link.sent, link.requests) == (Phase.MEET, Reason.NUMBERS, [], [])


def test_who_has_moved_before_it_follows_is_not_flown():
    link = DirectLink(make_drone(SCENARIO))
    link.drone.arm = lambda: (setattr(link, "shift", np.array([0.0, 0.0, 1.5])), setattr(link.drone, "armed", True))
    flown = flight(link, arm=True).fly()
    assert (flown.phase, flown.halt.reason) == (Phase.ENGAGE, Reason.JUMP)
    assert all(setpoint.throttle == 0 for _, setpoint, _ in link.sent)


def test_who_is_stopped_on_the_ground_before_it_follows_is_not_armed_again():
    link = DirectLink(make_drone(SCENARIO))
    link.drone.arm()
    link._script = lambda each: each.drone.disarm() if len(each.sent) == 5 else None
    flown = flight(link, arm=True).fly()
    assert (flown.phase, flown.halt.reason, link.requests) == (Phase.ENGAGE, Reason.DISARMED, [])


def test_who_tips_over_on_the_ground_gets_no_more_thrust():
    link, tipped = DirectLink(make_drone(SCENARIO)), []
    receive = link.receive

    def tip(wait):
        seen = receive(wait)
        if link.drone.armed and any(setpoint.throttle > 0 for _, setpoint, _ in link.sent):
            tipped.append(seen.time)
            angle = 0.1 * len(tipped)
            seen.state[3:7] = [np.cos(angle / 2), np.sin(angle / 2), 0.0, 0.0]
        return seen

    link.receive = tip
    flown = flight(link, arm=True).fly()
    assert (flown.phase, flown.halt.detail) == (Phase.TAKE_OFF, "it tips over")
    assert max(moment for moment, _, _ in link.sent) <= tipped[3]


def test_motors_that_stop_are_not_started_again():
    link = DirectLink(airborne())
    in_race(link, lambda each: each.drone.disarm(), 0.2)
    flown = flight(link, arm=True).fly()
    assert flown.halt.reason in {Reason.DISARMED, Reason.TAKEN_OVER}
    assert Request.ARM not in [request for _, request in link.requests]


def test_it_is_armed_only_when_that_is_asked_for():
    link = DirectLink(make_drone(SCENARIO))
    with pytest.raises(InputError, match="arm: direct is not armed"):
        flight(link).fly()
    assert (link.sent, link.requests, link.closed) == ([], [], True)


def test_a_refusal_to_arm_is_heard():
    link = DirectLink(make_drone(SCENARIO))
    link.refuses = "no magnetometer"
    flown = flight(link, arm=True).fly()
    assert (flown.phase, flown.halt.reason, flown.halt.detail) == (Phase.ENGAGE, Reason.REFUSED, "no magnetometer")
    assert all(setpoint.throttle == 0 for _, setpoint, _ in link.sent)


@pytest.mark.parametrize(("share", "reason"), [(0.15, Reason.NOT_LIFTED), (2.6, Reason.THRUST)])
def test_a_drone_of_another_file_is_not_flown(share, reason):
    link = DirectLink(make_drone(SCENARIO, share))
    flown = flight(link, arm=True).fly()
    assert (flown.halt.reason, flown.phase) == (reason, Phase.TAKE_OFF)
    assert link.requests[-1][1] is Request.LAND


def test_a_race_begins_above_where_the_vehicle_stands_and_turned_as_it_is():
    drone = make_drone(SCENARIO)
    drone.position[:], drone.yaw = (20.0, -7.0, 0.0), 2.0
    drone.__post_init__()
    link = DirectLink(drone)
    in_race(link, lambda each: setattr(each, "states", False), 0.3)
    flown = flight(link, arm=True, origin="here").fly()
    assert flown.phase is Phase.RACE
    log = flown.record.log(4)
    start = log.states[np.argmin(np.abs(log.times))]
    assert start[:3] == pytest.approx([0.0, 0.0, 1.0], abs=0.1)
    away = [np.linalg.norm(setpoint.reference[:3] - state[:3]) for _, setpoint, state in link.sent if setpoint.race_time]
    assert max(away) < 1.0  # in the vehicle's own world


def test_a_vehicle_that_takes_a_full_state_is_told_the_reference_and_the_race_beforehand():
    link = PuppetLink(make_drone(SCENARIO))
    flown = flight(link, arm=True, origin="3,4,0,90").fly()
    assert (flown.halt, flown.phase) == (None, Phase.LAND)
    assert np.isnan(flown.gain)  # its own controller flies
    assert all(np.isnan(setpoint.throttle) for _, setpoint, _ in link.sent)
    times, states = link.prepared
    racing = [setpoint for _, setpoint, _ in link.sent if setpoint.race_time is not None]
    for setpoint in racing[:: len(racing) // 5]:
        there = [np.interp(setpoint.race_time, times, column) for column in states[:, :3].T]
        assert setpoint.reference[:3] == pytest.approx(there, abs=1e-6)
    assert states[0, :3] == pytest.approx([3.0, 4.0, 1.0])


def test_a_terminal_that_takes_no_line_does_not_hold_up_a_flight(monkeypatch):
    monkeypatch.setattr(speaker, "PATIENCE", 0.01)
    stuck, said = threading.Event(), []
    with speaker.Speaker(lambda line: (stuck.wait(10.0), said.append(line))) as say:
        say("first")
        say("second")
    assert said == []
    stuck.set()
    say._thread.join()
    assert said == ["first", "second"]


def test_looking_sends_nothing():
    link, said = DirectLink(airborne()), []
    link.remark = "ages are not known"
    RealFlight(link, SCENARIO, PARAMETERS, FlightSettings(), said.append).look(1.0)
    assert (link.sent, link.requests, link.closed) == ([], [], True)
    assert "note: ages are not known" in said
    assert re.search(r"at \(.*\) m would send thrust (9\.[5-9]|10\.[0-2])\d m/s\^2, throttle (29|3\d) %", said[-1])


def test_states_that_are_too_few_and_no_vehicle_are_one_line():
    link = DirectLink(airborne())
    link.period = 0.04
    with pytest.raises(InputError, match="on: direct sends 25 states in a second: 100 are wanted"):
        flight(link).fly()
    link = DirectLink(airborne())
    link.there = False
    with pytest.raises(LinkError, match="no vehicle was heard on direct within 10 s"):
        flight(link).fly()
    assert link.closed


def test_what_cannot_be_flown_is_refused_before_anything_is_opened():
    with pytest.raises(InputError, match=r"geofence: the flight leaves it at .* braking included"):
        flight(DirectLink(airborne()), geofence="-1,1,-1,1,0,2")
    race = SCENARIO.race
    moving = race.model_copy(update={"track": race.track.model_copy(update={"start_velocity": (3.0, 0.0, 0.0)})})
    with pytest.raises(InputError, match="arc has a flying start"):
        RealFlight(DirectLink(airborne()), type(SCENARIO)(moving, SCENARIO.reference, SCENARIO.segments), PARAMETERS, FlightSettings())


@pytest.mark.check
def test_a_flight_is_the_same_whatever_the_machine_does_meanwhile():
    def commands(pause):
        link = DirectLink(airborne())
        in_race(link, lambda each: setattr(each, "states", False), 0.2)
        script = link._script
        link._script = lambda each: (time.sleep(pause if 50 < len(each.sent) < 60 else 0.0), script(each))
        flight(link).fly()
        return [(moment, setpoint.throttle, *setpoint.rates) for moment, setpoint, _ in link.sent]

    assert commands(0.0) == commands(0.02)
