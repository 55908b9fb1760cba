"""A link to a Crazyflie: what it sends, what it understands, and what it does not do."""

from __future__ import annotations

import os
from importlib.util import find_spec

import numpy as np
import pytest

from hotlap.core.errors import InputError
from hotlap.real_flight import open_link
from hotlap.real_flight.crazyflie import process
from hotlap.real_flight.crazyflie.address import address_of
from hotlap.real_flight.crazyflie.onboard import WATCHED, OnBoard
from hotlap.real_flight.crazyflie.packed import pack_state
from hotlap.real_flight.crazyflie.status import Status
from hotlap.real_flight.crazyflie.vehicle import STAMPS
from hotlap.real_flight.link import LinkError, Request, Setpoint
from hotlap.real_flight.paths import with_braking
from real_flight.crazyflies import PERIOD, SCENARIO, linked, name_of, serving, until
from real_flight.hangar import make_drone

needs_cflib = pytest.mark.skipif(find_spec("cflib") is None, reason="needs cflib")
HERE = np.array([0.5, -1.25, 1.5, 1, 0, 0, 0, 0.25, 0, -0.5, 0.1, -0.2, 0.3])
NOT_ASKED = "a setpoint that nobody has asked for"


def setpoint(link, race_time=None, reference=HERE):
    return Setpoint(link.now, 9.81, np.nan, reference[10:13], reference, np.array([1.0, -2.0, 0.5]), race_time)


@pytest.mark.parametrize(
    ("text", "uri", "trajectory", "follows"),
    [
        ("radio://0/80/2M/E7E7E7E7E7", "radio://0/80/2M/E7E7E7E7E7", False, False),
        ("radio://0/80/2M/E7E7E7E7E7?trajectory&rate_limit=200", "radio://0/80/2M/E7E7E7E7E7?rate_limit=200", True, False),
        ("usb://0", "usb://0", False, False),
        ("tcp://192.168.0.7:5000", "tcp://192.168.0.7:5000", False, False),
        ("udp://127.0.0.1:19850?clock=vehicle", "udp://127.0.0.1:19850", False, True),
    ],
)
def test_addresses(text, uri, trajectory, follows):
    address = address_of(text)
    assert (address.uri, address.trajectory, address.follows_clock) == (uri, trajectory, follows)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("radio:0", "is no address: radio://"),
        ("udp://127.0.0.1", "is no address"),
        ("udp://127.0.0.1:70000", "has no port from 1 to 65535"),
        ("radio://0/126/2M", "has no channel from 0 to 125"),
        ("radio://0/80/2M?trajektory", "'trajektory': there are"),
        ("udp://127.0.0.1:19850?rate_limit=2", "'rate_limit=2': there are"),
    ],
)
def test_what_is_no_address_says_so(text, reason):
    with pytest.raises(InputError, match=reason):
        address_of(text)


def test_a_missing_package_says_what_to_install(monkeypatch):
    monkeypatch.setattr(process, "PACKAGE", "cflib_that_is_not_there")
    with pytest.raises(InputError, match=r"pip install 'hotlap\[crazyflie\]'"):
        open_link("crazyflie:udp://127.0.0.1:19850", PERIOD)


@needs_cflib
def test_a_state_comes_as_it_is():
    with serving(airborne=True) as stand_in, linked(stand_in) as link:
        seen = [link.receive(1.0) for _ in range(15)]
        moment, state = min(stand_in.path, key=lambda one: abs(one[0] - seen[-1].time))
    assert moment == pytest.approx(seen[-1].time, abs=1e-3)
    assert seen[-1].state == pytest.approx(state, abs=0.01)
    assert np.diff([one.time for one in seen]) == pytest.approx(PERIOD)
    assert (seen[-1].armed, seen[-1].engaged, seen[-1].on_ground) == (True, False, False)
    assert seen[-1].voltage == pytest.approx(stand_in.board.drone.voltage, abs=0.1)
    assert "by its own controller" in link.remark


@needs_cflib
def test_a_full_state_arrives_as_it_was_told_and_only_after_it_was_to_follow():
    with serving(airborne=True) as stand_in, linked(stand_in) as link:
        link.receive(1.0)
        link.send(setpoint(link))
        link.request(Request.ENGAGE)
        until(lambda: link.receive(1.0).engaged)
        assert stand_in.setpoints == []
        link.send(setpoint(link))
        until(lambda: stand_in.setpoints, link)
        _, _, aim = stand_in.setpoints[0]
    for told, wanted in ((aim.position, HERE[:3]), (aim.velocity, HERE[7:10]), (aim.rates, HERE[10:13]), (aim.acceleration, [1, -2, 0.5])):
        assert told == pytest.approx(wanted, abs=2e-3)
    assert aim.attitude == pytest.approx(HERE[3:7], abs=2e-3)


@needs_cflib
@pytest.mark.parametrize("arms_itself", [False, True])
def test_nothing_turns_before_it_is_to_be_armed(arms_itself):
    with serving(arms_itself=arms_itself) as stand_in, linked(stand_in) as link:
        link.receive(1.0)
        link.request(Request.ENGAGE)
        for _ in range(10):
            seen = link.receive(1.0)
            link.send(setpoint(link))
        assert (seen.engaged, seen.armed, stand_in.setpoints, stand_in.requests) == (True, False, [], [])
        link.request(Request.ARM)
        until(lambda: link.receive(1.0).armed)
        link.send(setpoint(link))
        until(lambda: stand_in.setpoints, link)
    assert [what for _, what in stand_in.requests] == ["arm"]


@needs_cflib
@pytest.mark.parametrize(
    ("request_", "said"), [(Request.LAND, ["land", "give way"]), (Request.HOLD, ["hold", "give way"]), (Request.DISARM, ["stop"])]
)
def test_what_it_is_asked_for(request_, said):
    with serving(airborne=True) as stand_in, linked(stand_in) as link:
        link.receive(1.0)
        link.request(Request.ENGAGE)
        for _ in range(5):
            link.send(setpoint(link, reference=stand_in.board.drone.state))
            link.receive(1.0)
        link.request(request_)
        until(lambda: not link.receive(1.0).engaged)
        assert [what for _, what in stand_in.requests] == said
        assert stand_in.board.locked is (request_ is Request.DISARM)


@needs_cflib
def test_a_link_that_is_closed_says_nothing_more():
    with serving(airborne=True, lockstep=False) as stand_in:
        with linked(stand_in) as link:
            link.request(Request.ENGAGE)
            link.receive(1.0)
            link.send(setpoint(link))
            until(lambda: stand_in.setpoints)
        before = len(stand_in.setpoints)
        now = stand_in.now
        until(lambda: stand_in.now > now + 0.1)
        assert (len(stand_in.setpoints), stand_in.requests) == (before, [])


@needs_cflib
def test_where_hotlap_dies_it_is_landed():
    with serving(airborne=True, lockstep=False) as stand_in, linked(stand_in) as link:
        link.request(Request.ENGAGE)
        link.receive(1.0)
        link.send(setpoint(link))
        until(lambda: stand_in.setpoints)
        link._process._process.stdin.close()
        until(lambda: [what for _, what in stand_in.requests] == ["land", "give way"])


@needs_cflib
def test_a_trajectory_is_uploaded_and_begun_with_the_race():
    reference = with_braking(SCENARIO).reference
    states = np.hstack([reference.position, reference.attitude, reference.velocity, reference.rates])
    with serving(airborne=True) as stand_in, linked(stand_in, "trajectory") as link:
        told = link.prepare(reference.times, states)
        link.receive(1.0)
        link.request(Request.ENGAGE)
        link.send(setpoint(link, reference=states[0]))
        until(lambda: stand_in.setpoints, link)
        link.send(setpoint(link, 0.0, states[0]))
        until(lambda: stand_in.requests, link)
        begun = stand_in.requests[0][0]
        while stand_in.now < begun + 1.5:
            link.receive(1.0)
            link.send(setpoint(link, stand_in.now - begun))
        moment, state = stand_in.path[-1]
        assert state[:3] == pytest.approx(reference.position_at(np.array([moment - begun]))[0], abs=0.25)
        assert (len(stand_in.setpoints), [what for _, what in stand_in.requests]) == (1, ["start", "give way"])
        assert stand_in.board._beaten == pytest.approx(stand_in.now, abs=0.3)
    assert "pieces, at most" in told


@needs_cflib
@pytest.mark.check
def test_a_trajectory_that_is_left_is_landed_before_its_watchdog_stops_it():
    reference = with_braking(SCENARIO).reference
    states = np.hstack([reference.position, reference.attitude, reference.velocity, reference.rates])
    heights = []
    with serving(airborne=True, lockstep=False) as stand_in:
        stand_in.each_step = lambda one: heights.append(one.board.drone.state[2]) if one.board.locked else None
        with linked(stand_in, "trajectory") as link:
            link.prepare(reference.times, states)
            link.request(Request.ENGAGE)
            link.receive(1.0)
            link.send(setpoint(link, 0.0, states[0]))
            until(lambda: stand_in.requests, link)
            link.request(Request.HOLD)  # nobody could leave it there
            until(lambda: not link.receive(1.0).engaged)
        until(lambda: heights)
    assert [what for _, what in stand_in.requests][:4] == ["start", "give way", "land", "give way"]
    assert heights[0] == pytest.approx(stand_in.board.drone.ground, abs=0.02)


def test_a_watchdog_without_beats_stops_the_motors():
    board = OnBoard(make_drone(SCENARIO))
    board.hover(SCENARIO.reference.position[0])
    board.beat()
    board.advance(WATCHED - 0.1)
    board.advance(0.05)
    assert board.armed
    board.advance(0.2)
    board.advance(0.05)
    assert (board.locked, board.armed) == (True, False)


@needs_cflib
def test_who_is_mute_asks_for_states_and_nothing_else():
    with serving(airborne=True) as stand_in, linked(stand_in, mute=True) as link:
        for _ in range(5):
            link.receive(1.0)
            link.request(Request.ENGAGE)
            link.request(Request.ARM)
            link.send(setpoint(link))
            link.request(Request.LAND)
        assert (stand_in.setpoints, stand_in.requests) == ([], [])


@needs_cflib
@pytest.mark.parametrize(
    ("settings", "reason"),
    [({"lacks": "supervisor.info"}, "does not log: .*supervisor.info"), ({"protocol": 5}, r"too old \(CRTP 5, 9 is needed\)")],
)
def test_who_cannot_be_flown_says_why(settings, reason):
    with serving(**settings) as stand_in, pytest.raises(LinkError, match=reason), linked(stand_in):
        pass


@needs_cflib
def test_who_is_not_there_is_missed():
    with serving(silent=True) as stand_in:
        link = open_link(name_of(stand_in), PERIOD)
        with pytest.raises(LinkError, match=r"no Crazyflie was heard on crazyflie:udp://127\.0\.0\.1:\S* within 0\.3 s"):
            link.open(0.3)
        link.close()


@needs_cflib
def test_a_process_that_dies_is_a_link_that_is_lost():
    with serving(airborne=True, lockstep=False) as stand_in, linked(stand_in) as link:
        os.kill(link._process._process.pid, 9)
        until(lambda: link.silent_for > link.patience, link)


@needs_cflib
def test_a_race_that_its_numbers_cannot_hold_is_refused():
    far = np.tile(HERE, (10, 1))
    far[-1, 0] = 40.0
    link = open_link("crazyflie:udp://127.0.0.1:19850", PERIOD)
    with pytest.raises(LinkError, match=r"knows a position of 32\.8 m at most in each axis, and the race has 40\.0"):
        link.prepare(np.arange(10.0), far)


@needs_cflib
def test_stamps_that_begin_anew_go_on():
    link = open_link("crazyflie:udp://127.0.0.1:19850?clock=vehicle", PERIOD)
    numbers = pack_state(HERE)
    for stamp in (STAMPS - 20, 0, 20):
        link._hear_state(stamp, int(Status.ARMED), *numbers)
        seen = link.receive(1.0)
    assert seen.time == pytest.approx(1e-3 * (STAMPS + 20))
    assert seen.state == pytest.approx(HERE, abs=2e-3)
