"""Whom a connection of MAVLink belongs to: ports, senders, lines that are gone."""

from __future__ import annotations

import socket
from contextlib import ExitStack, contextmanager, suppress

import numpy as np
import pytest

pytest.importorskip("pymavlink")

from hotlap.real_flight.link import LinkError, Request, Setpoint
from hotlap.real_flight.mavlink import package
from hotlap.real_flight.mavlink.address import Address, address_of
from hotlap.real_flight.mavlink.autopilots import CUSTOM, PX4
from hotlap.real_flight.mavlink.frames import odometry_of
from hotlap.real_flight.mavlink.package import connect
from hotlap.real_flight.mavlink.vehicle import MavlinkVehicle
from real_flight.test_mavlink_vehicle import RECEIVE, STATE, UNKNOWN


@contextmanager
def listening(count):
    """A link that listens, and so many vehicles that talk to its port, all with the same number."""
    with ExitStack() as stack:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        vehicle = MavlinkVehicle(address_of(f"udpin:127.0.0.1:{port}"), 0.01)
        stack.callback(vehicle.close)
        talkers = [connect(Address("", f"udpout:127.0.0.1:{port}"), 1, 1)[0] for _ in range(count)]
        for talker in talkers:
            stack.callback(talker.close)
        yield vehicle, talkers


def beat(talker):
    talker.mav.heartbeat_send(2, PX4, CUSTOM, 0, 4)


def say(talker, time):
    talker.mav.odometry_send(round(1e6 * time), *odometry_of(STATE).values(), UNKNOWN, UNKNOWN, 0)


def read(vehicle):
    while vehicle._read(0.05):
        pass


def heard_by(talker):
    talker.select(0.05)
    heard = []
    while (message := talker.recv_msg()) is not None:
        heard.append(message.get_type())
    return heard


def test_two_vehicles_on_a_port_are_not_flown():
    with listening(2) as (vehicle, talkers):
        for talker in talkers:
            beat(talker)
        say(talkers[0], 1.0)
        read(vehicle)
        with pytest.raises(LinkError, match=r"two vehicles are heard on .*: system 1 at 127\.0\.0\.1:\d+ and system 1 at 127.*; give each"):
            vehicle.receive(RECEIVE)


def test_one_who_comes_later_is_sent_nothing_and_not_heard():
    with listening(2) as (vehicle, (first, second)):
        beat(first)
        read(vehicle)
        vehicle.request(Request.ENGAGE)
        beat(second)
        say(second, 9.0)
        say(first, 1.0)
        assert vehicle.receive(RECEIVE).time == 1.0
        vehicle.request(Request.ARM)
        vehicle.send(Setpoint(1.0, 9.81, 0.3, np.zeros(3), STATE, np.zeros(3)))
        assert {"COMMAND_LONG", "SET_ATTITUDE_TARGET"} <= set(heard_by(first))
        assert heard_by(second) == []


def test_what_was_said_before_it_is_opened_is_old():
    with listening(1) as (vehicle, (talker,)):
        beat(talker)
        say(talker, 1.0)
        with pytest.raises(LinkError, match="no vehicle was heard"):
            vehicle.open(0.1)


def test_a_port_that_listens_is_nobody_elses():
    with listening(0) as (vehicle, _):
        port = vehicle._line._connection.port.getsockname()[1]
        with pytest.raises(LinkError, match="cannot be opened: Address already in use"):
            MavlinkVehicle(address_of(f"udpin:127.0.0.1:{port}"), 0.01)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as thief:
            thief.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            with pytest.raises(OSError, match="in use"):
                thief.bind(("127.0.0.1", port))


def test_tcp_that_ends_is_silent_and_one_line(capfd):
    with socket.create_server(("127.0.0.1", 0)) as server:
        vehicle = MavlinkVehicle(address_of(f"tcp:127.0.0.1:{server.getsockname()[1]}"), 0.01)
        server.accept()[0].close()
        with pytest.raises(LinkError, match="no vehicle was heard"):
            vehicle.open(0.1)
        vehicle.close()
    assert capfd.readouterr().out == ""


def test_tcp_that_does_not_answer_is_not_waited_for(monkeypatch):
    monkeypatch.setattr(package, "CONNECTING", 0.1)
    with ExitStack() as stack:
        server = stack.enter_context(socket.socket())
        server.bind(("127.0.0.1", 0))
        server.listen(0)
        for _ in range(3):  # its queue is full
            waiting = stack.enter_context(socket.socket())
            waiting.setblocking(False)
            with suppress(BlockingIOError):
                waiting.connect(server.getsockname())
        with pytest.raises(LinkError, match="cannot be opened: timed out"):
            MavlinkVehicle(address_of(f"tcp:127.0.0.1:{server.getsockname()[1]}"), 0.01)
    assert socket.getdefaulttimeout() is None


@pytest.mark.parametrize("name", ["flight.tlog", "flight.bin", "flight.elf", "flight.log"])
def test_a_file_is_no_serial_line_whatever_its_name(name, tmp_path):
    (tmp_path / name).write_bytes(bytes(100))
    with pytest.raises(Exception, match="serial"):
        connect(address_of(f"serial:{tmp_path / name}:57600"), 1, 1)
