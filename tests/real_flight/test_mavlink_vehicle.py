"""What a MAVLink vehicle is told and what is heard of it, message by message, without a clock that runs."""

from __future__ import annotations

import math
from contextlib import contextmanager

import numpy as np
import pytest

pytest.importorskip("pymavlink")

from hotlap.real_flight.link import LinkError, Request, Setpoint
from hotlap.real_flight.mavlink.address import Address, address_of
from hotlap.real_flight.mavlink.autopilots import ARDUPILOT, ARMED, AUTOPILOTS, CUSTOM, PX4
from hotlap.real_flight.mavlink.frames import odometry_of
from hotlap.real_flight.mavlink.package import connect
from hotlap.real_flight.mavlink.vehicle import MavlinkVehicle

UNKNOWN = [math.nan] * 21
STATE = np.array([1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.1])
RECEIVE = 0.5  # s at most; what is waited for is there already


class Peer:
    """The other end of a connection."""

    def __init__(self):
        self.connection, self.messages = connect(Address("", "udpin:127.0.0.1:0"), 1, 1)
        self.vehicle = MavlinkVehicle(address_of(f"udpout:127.0.0.1:{self.connection.port.getsockname()[1]}"), 0.01)

    def meet(self, autopilot=PX4, custom=0, base=CUSTOM):
        """Both know of each other."""
        self.vehicle._read(0.0)  # its heartbeat
        self.hear()
        self.say("heartbeat", self.messages.MAV_TYPE_QUADROTOR, autopilot, base, custom, self.messages.MAV_STATE_ACTIVE)
        self.let_read()

    def say(self, kind, *values):
        getattr(self.connection.mav, f"{kind}_send")(*values)

    def state(self, time, state=STATE):
        self.say("odometry", round(1e6 * time), *odometry_of(state).values(), UNKNOWN, UNKNOWN, 0)

    def let_read(self):
        """The vehicle takes in all that has come."""
        while self.vehicle._read(0.05):
            pass

    def hear(self):
        """All that has come, by kind; the last of each."""
        self.connection.select(0.2)
        heard = {}
        while (message := self.connection.recv_msg()) is not None:
            heard[message.get_type() if message.get_type() != "COMMAND_LONG" else f"COMMAND_{message.command}"] = message
        return heard


@pytest.fixture
def peer():
    made = Peer()
    yield made
    made.vehicle.close()
    made.connection.close()


def test_of_several_states_that_wait_the_newest_is_flown_with(peer):
    peer.meet()
    for step in range(5):
        peer.state(10.0 + 0.01 * step, STATE + [step, *[0.0] * 12])
    seen = peer.vehicle.receive(RECEIVE)
    assert (seen.time, seen.state[0]) == (pytest.approx(10.04), pytest.approx(5.0))
    assert seen.state[7:] == pytest.approx(STATE[7:])
    assert peer.vehicle.receive(0.0) is None


def test_a_heartbeat_is_sent_and_the_time_is_asked_and_answered(peer):
    peer.meet()
    peer.vehicle._read(0.0)
    heard = peer.hear()
    assert heard["TIMESYNC"].tc1 == 0
    assert heard["TIMESYNC"].ts1 > 0
    peer.say("timesync", 0, 123)
    peer.let_read()
    answer = peer.hear()["TIMESYNC"]
    assert answer.ts1 == 123
    assert answer.tc1 > 0
    assert "TIMESYNC is not answered" in peer.vehicle.remark
    peer.say("timesync", round(1e9 * 70.0), heard["TIMESYNC"].ts1 + 1)  # an answer to somebody else
    peer.let_read()
    assert peer.vehicle.remark != ""
    peer.say("timesync", round(1e9 * 50.0), heard["TIMESYNC"].ts1)
    peer.let_read()
    assert peer.vehicle.remark == ""
    assert peer.vehicle.now >= 50.0


def test_heartbeats_are_those_of_an_onboard_computer_of_the_vehicle(peer):
    peer.vehicle._read(0.0)
    heard = peer.hear()["HEARTBEAT"]
    assert (heard.autopilot, heard.get_srcComponent()) == (8, 191)
    assert heard.type == peer.messages.MAV_TYPE_ONBOARD_CONTROLLER


def test_a_setpoint_is_rates_and_thrust_without_attitude(peer):
    peer.meet()
    peer.vehicle.send(Setpoint(12.5, 9.81, 0.3, np.array([0.1, 0.2, 0.3]), STATE, np.zeros(3)))
    told = peer.hear()["SET_ATTITUDE_TARGET"]
    assert (told.time_boot_ms, told.type_mask, told.target_system, told.target_component) == (12500, 128, 1, 1)
    assert [told.body_roll_rate, told.body_pitch_rate, told.body_yaw_rate, told.thrust] == pytest.approx([0.1, -0.2, -0.3, 0.3])
    assert told.get_srcSystem() == 1  # a part of the vehicle


@pytest.mark.parametrize("autopilot", [PX4, ARDUPILOT])
@pytest.mark.parametrize("request_", [Request.ENGAGE, Request.LAND, Request.HOLD])
def test_modes_are_asked_for_and_recognised(peer, autopilot, request_):
    peer.meet(autopilot)
    peer.vehicle.request(request_)
    asked = peer.hear()["COMMAND_176"]
    assert (asked.param1, (asked.param2, asked.param3)) == (CUSTOM, AUTOPILOTS[autopilot].modes[request_])
    peer.meet(autopilot, AUTOPILOTS[autopilot].custom_mode(request_), CUSTOM | ARMED)
    peer.state(1.0)
    seen = peer.vehicle.receive(RECEIVE)
    assert (seen.armed, seen.engaged) == (True, request_ is Request.ENGAGE)


def test_arming_and_disarming_are_commands_and_a_refusal_is_in_words(peer):
    peer.meet()
    peer.vehicle.request(Request.ARM)
    assert peer.hear()["COMMAND_400"].param1 == 1
    peer.say("statustext", peer.messages.MAV_SEVERITY_CRITICAL, b"Preflight Fail: compass")
    peer.say("command_ack", 400, peer.messages.MAV_RESULT_DENIED)
    peer.let_read()
    assert peer.vehicle.refusal == "arming denied (Preflight Fail: compass)"
    peer.vehicle.request(Request.DISARM)
    told = peer.hear()["COMMAND_400"]
    assert (told.param1, told.param2, peer.vehicle.refusal) == (0, 21196, "")


def test_who_speaks_without_heartbeats_counts_as_silent(peer):
    peer.meet()
    peer.state(1.0)
    assert peer.vehicle.receive(RECEIVE) is not None
    assert peer.vehicle.silent_for < 3.0
    peer.vehicle._heartbeat -= 10.0
    peer.state(2.0)
    assert peer.vehicle.receive(RECEIVE) is not None
    assert peer.vehicle.silent_for > 7.0


def test_battery_and_ground_are_heard(peer):
    peer.meet()
    peer.say("sys_status", 0, 0, 0, 0, 15200, -1, -1, 0, 0, 0, 0, 0, 0)
    peer.say("extended_sys_state", 0, peer.messages.MAV_LANDED_STATE_ON_GROUND)
    peer.state(1.0)
    seen = peer.vehicle.receive(RECEIVE)
    assert (seen.voltage, seen.on_ground) == (pytest.approx(15.2), True)
    peer.say("sys_status", 0, 0, 0, 0, 65535, -1, -1, 0, 0, 0, 0, 0, 0)
    peer.state(2.0)
    assert math.isnan(peer.vehicle.receive(RECEIVE).voltage)


def test_what_others_say_is_not_heeded(peer):
    peer.meet()
    peer.vehicle.request(Request.ENGAGE)
    peer.connection.mav.srcSystem = 7
    peer.state(1.0)
    peer.say("heartbeat", peer.messages.MAV_TYPE_QUADROTOR, PX4, CUSTOM | ARMED, 6 << 16, peer.messages.MAV_STATE_ACTIVE)
    peer.let_read()
    peer.connection.mav.srcSystem = 1
    peer.state(2.0)
    seen = peer.vehicle.receive(RECEIVE)
    assert (seen.time, seen.armed) == (2.0, False)


def test_a_ground_station_and_a_companion_say_nothing_about_the_vehicle(peer):
    peer.meet(base=CUSTOM | ARMED)
    messages = peer.messages
    for system, component, kind, autopilot in ((255, 190, "MAV_TYPE_GCS", 8), (1, 191, "MAV_TYPE_ONBOARD_CONTROLLER", 8)):
        peer.connection.mav.srcSystem, peer.connection.mav.srcComponent = system, component
        peer.say("heartbeat", getattr(messages, kind), autopilot, 0, 0, messages.MAV_STATE_ACTIVE)
        peer.state(50.0)
    peer.connection.mav.srcSystem, peer.connection.mav.srcComponent = 1, 1
    peer.say("command_ack", 400, messages.MAV_RESULT_DENIED, 0, 0, 255, 190)  # to the ground station
    peer.state(2.0)
    seen = peer.vehicle.receive(RECEIVE)
    assert (seen.time, seen.armed, peer.vehicle.refusal) == (2.0, True, "")


def test_who_follows_is_asked_often_whether_it_still_does(peer):
    peer.meet(custom=AUTOPILOTS[PX4].custom_mode(Request.ENGAGE))
    peer.vehicle._read(0.0)
    assert peer.hear()["COMMAND_512"].param1 == peer.messages.MAVLINK_MSG_ID_HEARTBEAT
    peer.vehicle._read(0.0)
    assert "COMMAND_512" not in peer.hear()
    peer.vehicle._asked_still -= 0.3
    peer.vehicle._read(0.0)
    assert "COMMAND_512" in peer.hear()


@pytest.mark.parametrize("request_", [Request.LAND, Request.HOLD, Request.DISARM])
def test_who_has_left_is_not_asked_to_stop_though_no_state_comes_that_says_so(peer, request_):
    for followed in (True, False):
        peer.meet(custom=AUTOPILOTS[PX4].custom_mode(Request.ENGAGE if followed else Request.HOLD), base=CUSTOM | ARMED)
    peer.hear()
    peer.vehicle.request(request_)
    assert not {"COMMAND_176", "COMMAND_400"} & set(peer.hear())
    assert peer.vehicle.refusal == "it no longer follows hotlap, and is left alone"
    peer.vehicle.request(Request.ENGAGE)
    assert "COMMAND_176" in peer.hear()


def test_who_never_stops_talking_does_not_hold_up_a_flight(peer):
    peer.meet()
    peer.state(1.0)
    read = peer.vehicle._read
    peer.vehicle._read = lambda wait: read(wait) or True
    assert peer.vehicle.receive(RECEIVE) is not None


@contextmanager
def speaking(peer, *messages):
    """Whenever the vehicle reads, the peer has just said something."""
    read = peer.vehicle._read

    def after(wait):
        for message in messages:
            peer.say(*message)
        return read(wait)

    peer.vehicle._read = after
    yield


@pytest.mark.parametrize(
    ("autopilot", "kind", "reason"),
    [
        (PX4, "MAV_TYPE_QUADROTOR", "sends neither ODOMETRY nor LOCAL_POSITION_NED with ATTITUDE_QUATERNION: has it a position"),
        (PX4, "MAV_TYPE_FIXED_WING", "no vehicle was heard"),
        (8, "MAV_TYPE_GCS", "no vehicle was heard"),
    ],
)
def test_what_cannot_be_flown_is_said_when_it_is_opened(peer, autopilot, kind, reason):
    beat = ("heartbeat", getattr(peer.messages, kind), autopilot, CUSTOM, 0, peer.messages.MAV_STATE_ACTIVE)
    peer.vehicle._read(0.0)
    peer.hear()
    with speaking(peer, beat), pytest.raises(LinkError, match=reason):
        peer.vehicle.open(0.3)


def test_states_are_asked_for_at_the_rate_of_the_controller(peer):
    peer.meet()
    peer.vehicle._ask_for_messages()
    peer.connection.select(0.2)
    asked = {}
    while (message := peer.connection.recv_msg()) is not None:
        if message.get_type() == "COMMAND_LONG":
            asked[message.param1] = message.param2
    assert {number: asked[number] for number in (331, 32, 31)} == {331: 10000, 32: 10000, 31: 10000}
