"""Flights over MAVLink: UDP on loopback, against a stand-in that owns the clock, so that they are quick, and each time alike."""

from __future__ import annotations

import threading
from contextlib import contextmanager

import numpy as np
import pytest

pytest.importorskip("pymavlink")

from hotlap.real_flight import flight as flight_loop
from hotlap.real_flight import open_link
from hotlap.real_flight.flight import RealFlight
from hotlap.real_flight.guard import Reason
from hotlap.real_flight.link import LinkError
from hotlap.real_flight.mavlink.autopilots import ARDUPILOT, PX4
from hotlap.real_flight.mavlink.stand_in import StandIn, Weather
from hotlap.real_flight.settings import FlightSettings, Phase
from hotlap.real_flight.stand_in import Mode
from real_flight.hangar import DELAY, make_drone, make_scenario

SCENARIO = make_scenario()
WEATHER = Weather(loss=0.03, latency=0.002, jitter=0.004, position=0.005, velocity=0.02, attitude=0.002)
UPLINK = 0.004  # s, of that weather in the mean


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """Nobody waits for long."""
    for name, short in {"MEETING": 0.2, "STEADY_FOR": 1.0}.items():
        monkeypatch.setattr(flight_loop, name, short)


@contextmanager
def serving(**settings):
    """A stand-in that listens, in a thread of its own."""
    drone = make_drone(SCENARIO, delay=DELAY - UPLINK)
    if settings.pop("airborne", False):
        drone.hover(SCENARIO.reference.position[0])
    stand_in = StandIn("udpin:127.0.0.1:0", drone, **settings)
    thread = threading.Thread(target=stand_in.serve, daemon=True)
    thread.start()
    try:
        yield stand_in
    finally:
        stand_in.stop()
        thread.join()


def fly(stand_in, **settings):
    link = open_link(f"mavlink:udpout:127.0.0.1:{stand_in.port}?clock=vehicle", SCENARIO.race.controller.period)
    return RealFlight(link, SCENARIO, SCENARIO.space.first_guess(1), FlightSettings(**settings)).fly()


def away(stand_in, begun):
    """Largest distance of the true path from the reference's [m]."""
    path = [(moment - begun, state[:3]) for moment, state in stand_in.path if begun <= moment <= begun + SCENARIO.reference.duration]
    times, places = np.array([moment for moment, _ in path]), np.array([place for _, place in path])
    return float(np.linalg.norm(places - SCENARIO.reference.position_at(times), axis=1).max())


def check(stand_in, flown):
    """A flight that went to its end."""
    assert (flown.halt, flown.phase, stand_in.drone.crashed) == (None, Phase.LAND, False)
    assert away(stand_in, flown.record.race_begun) < 0.5
    assert flown.gain == pytest.approx(0.85, rel=0.05)
    assert max(np.diff(stand_in.heartbeats)) < 1.2
    assert not any(flown.geofence.outside(told.state[:3]) for told in stand_in.setpoints if told.engaged)
    begun = flown.record.race_begun
    racing = [told.time for told in stand_in.setpoints if begun < told.time < begun + 3.0]
    assert len(racing) > 0.9 * 3.0 / SCENARIO.race.controller.period  # at the control rate, but for what was lost


@pytest.mark.check
def test_a_lap_over_a_link_that_loses_and_delays_messages():
    with serving(weather=WEATHER, seed=3, airborne=True) as stand_in:
        flown = fly(stand_in)
        check(stand_in, flown)
    assert "PX4, system 1" in flown.vehicle
    assert [what for _, what in stand_in.requests if what != "land"] == ["engage"]  # it was armed already
    ages = [seen.age for seen in flown.record.seen]
    assert np.median(ages) == pytest.approx(UPLINK, abs=0.003)


@pytest.mark.check
@pytest.mark.parametrize(("autopilot", "odometry"), [(PX4, True), (PX4, False), (ARDUPILOT, True), (ARDUPILOT, False)])
def test_a_lap_from_the_ground_with_each_autopilot_and_each_kind_of_state(autopilot, odometry):
    with serving(weather=WEATHER, autopilot=autopilot, odometry=odometry) as stand_in:
        check(stand_in, fly(stand_in, arm=True))
    assert [what for _, what in stand_in.requests][:2] == ["engage", "arm"]


@pytest.mark.check
def test_a_state_that_grows_old_stops_it_within_half_a_second():
    cut = []

    def fall_silent(stand_in):
        if not cut and sum(told.throttle > 0 for told in stand_in.setpoints) > 200:
            cut.append(stand_in.now)
            stand_in.silent = True  # but for its clock

    with serving(each_step=fall_silent, airborne=True) as stand_in:
        flown = fly(stand_in, on_stop="hold")
    assert flown.halt.reason is Reason.STALE
    stopped = next(moment for moment, what in stand_in.requests if what == "hold")
    assert cut[0] < stopped < cut[0] + 0.5
    assert max(told.time for told in stand_in.setpoints) <= cut[0] + 0.01


def test_a_pilot_who_takes_over_is_noticed_between_two_heartbeats():
    cut = []

    def take_over(stand_in):
        if not cut and sum(told.throttle > 0 for told in stand_in.setpoints) > 200:
            cut.append(stand_in.now)
            stand_in.drone.change(Mode.HOLD)

    with serving(each_step=take_over, airborne=True) as stand_in:
        flown = fly(stand_in, on_stop="disarm")
    assert flown.halt.reason is Reason.TAKEN_OVER
    assert max(told.time for told in stand_in.setpoints) < cut[0] + 0.3
    assert [what for _, what in stand_in.requests] == ["engage"]


def test_an_arm_that_is_refused_says_why():
    with serving(refuses="Preflight Fail: no GPS") as stand_in:
        flown = fly(stand_in, arm=True)
    assert (flown.phase, flown.halt.reason) == (Phase.ENGAGE, Reason.REFUSED)
    assert "arming refused for now (Preflight Fail: no GPS)" in flown.halt.detail
    assert not stand_in.drone.armed


def test_ardupilot_that_takes_thrust_for_a_climb_rate_is_not_flown():
    with serving(autopilot=ARDUPILOT, options=0) as stand_in, pytest.raises(LinkError, match=r"GUID_OPTIONS is 0: set its bit 3 \(\+8\)"):
        fly(stand_in, arm=True)
    assert stand_in.setpoints == []


def test_who_is_not_there_is_missed():
    link = open_link("mavlink:udpin:127.0.0.1:1029?clock=vehicle", 0.01)
    with pytest.raises(LinkError, match=r"no vehicle was heard on mavlink:udpin:127\.0\.0\.1:1029\S* within 0\.2 s: does it send"):
        link.open(0.2)
    link.close()


def test_a_mute_link_sends_heartbeats_alone():
    with serving(lockstep=False, airborne=True) as stand_in:
        link = open_link(f"mavlink:udpout:127.0.0.1:{stand_in.port}?clock=vehicle", 0.01, mute=True)
        stand_in.setpoints.clear()
        RealFlight(link, SCENARIO, SCENARIO.space.first_guess(1), FlightSettings()).look(0.3)
    assert len(stand_in.heartbeats) > 0
    assert (stand_in.setpoints, stand_in.requests, stand_in.heard - {"HEARTBEAT"}) == ([], [], set())


@pytest.mark.check
def test_two_flights_in_the_same_weather_are_the_same():
    def commands():
        with serving(weather=WEATHER, seed=7, airborne=True, each_step=stop_soon) as stand_in:
            fly(stand_in)
        return [(told.time, told.throttle) for told in stand_in.setpoints]

    def stop_soon(stand_in):
        stand_in.silent = stand_in.silent or sum(told.throttle > 0 for told in stand_in.setpoints) > 250

    assert commands() == commands()
