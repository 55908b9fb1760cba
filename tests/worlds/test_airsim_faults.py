"""Whatever AirSim answers, or does not: one line that says what is wrong, in time."""

from __future__ import annotations

import socket
import threading
from contextlib import contextmanager

import msgpack
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hotlap.worlds.airsim import open_simulator
from hotlap.worlds.airsim.client import Client
from hotlap.worlds.airsim.simulator import AirSim
from hotlap.worlds.simulator import SimulatorError
from worlds.airsim_flights import PATIENCE, connect, fly, served


@contextmanager
def answering(reply):
    """A server that answers whatever it gets with what `reply` makes of it; None ends the connection."""
    listener = socket.create_server(("127.0.0.1", 0))

    def serve() -> None:
        connection, _ = listener.accept()
        with connection:
            unpacker = msgpack.Unpacker(raw=False)
            while data := connection.recv(65536):
                unpacker.feed(data)
                for message in unpacker:
                    answer = reply(*message)
                    if answer is None:
                        return
                    connection.sendall(answer)

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield Client("127.0.0.1", listener.getsockname()[1], PATIENCE)
    finally:
        listener.close()
        thread.join(10)


def test_nobody_listens():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    with pytest.raises(SimulatorError, match=rf"^AirSim at 127.0.0.1:{port}: nobody listens there: is the simulator running, with"):
        open_simulator(None, 0, f"127.0.0.1:{port}")


def test_a_host_that_is_none():
    with pytest.raises(SimulatorError, match="cannot be reached"):
        open_simulator(None, 0, "no host at all")
    with pytest.raises(SimulatorError, match="cannot be reached: this is no name of a machine"):
        open_simulator(None, 0, "x" * 300)


def test_an_unknown_vehicle_is_named_with_those_there_are():
    with served() as server, pytest.raises(SimulatorError, match="there is no vehicle named 'Drone7'; available: Drone1"):
        connect(server, "Drone7")
    with served() as server, connect(server, "Drone1") as simulator:
        fly(simulator)


@pytest.mark.parametrize("method", ["ping", "reset", "simContinueForTime", "getMultirotorState", "isApiControlEnabled"])
def test_a_silent_server_is_given_up(method):
    lost = pytest.raises(SimulatorError, match=rf": {method} was not answered within (1|1.\d+) s$")
    with served(silent_at=method) as server, lost, connect(server, timeout=PATIENCE) as simulator:
        fly(simulator)


@pytest.mark.parametrize("raw", [b"HTTP/1.1 400 Bad Request\r\n\r\n", b"\xc1\xc1\xc1", b"\x94\x01\x01\xc0", b"\x93\x01\x02\x03"])
def test_garbage_is_not_taken_for_an_answer(raw):
    with (
        served(raw={"getMultirotorState": raw}) as server,
        pytest.raises(SimulatorError) as error,
        connect(server, timeout=PATIENCE) as simulator,
    ):
        fly(simulator)
    assert "is not msgpack-rpc" in str(error.value) or "was not answered" in str(error.value)


def test_a_simulator_that_is_closed_in_flight_is_lost():
    with served(cut_at=20) as server, connect(server) as simulator:
        with pytest.raises(SimulatorError, match=r"it has closed the connection|the connection broke"):
            fly(simulator)
        server.kill()
        with pytest.raises(SimulatorError, match="nobody listens there"):
            connect(server, timeout=PATIENCE)


def test_lost_control_is_noticed():
    with served(disowned_at=20) as server, connect(server) as simulator, pytest.raises(SimulatorError, match="API control was lost"):
        fly(simulator)


def test_a_call_that_the_server_does_not_have_is_named():
    with answering(
        lambda kind, number, method, arguments: msgpack.packb([1, number, f"could not find function '{method}'", None])
    ) as client:
        with pytest.raises(SimulatorError, match="ping: could not find function 'ping'"):
            AirSim(client)
        client.close()


@pytest.mark.parametrize(
    ("method", "altered", "message"),
    [
        ("getMultirotorState", lambda told: told | {"timestamp": None}, "timestamp must be a whole number, not None"),
        ("getMultirotorState", lambda told: [], "timestamp must be a whole number, not None"),
        ("getMultirotorState", lambda told: {"timestamp": 1}, "kinematics_estimated: is missing"),
        (
            "getMultirotorState",
            lambda told: (
                told | {"kinematics_estimated": told["kinematics_estimated"] | {"position": {"x_val": "a", "y_val": 0, "z_val": 0}}}
            ),
            "getMultirotorState.kinematics_estimated.position.x_val: must be a finite number",
        ),
        ("simGetGroundTruthEnvironment", lambda told: {"air_density": 0}, "air_density: must be greater than 0"),
        ("simGetGroundTruthEnvironment", lambda told: 7, "simGetGroundTruthEnvironment: must be a table, not 7"),
    ],
)
def test_what_makes_no_sense_is_named(method, altered, message):
    with served(altered={method: altered}) as server, pytest.raises(SimulatorError, match=message), connect(server) as simulator:
        fly(simulator)


def test_a_clock_that_stands_still_is_noticed():
    with (
        served(altered={"getMultirotorState": lambda told: told | {"timestamp": 5}}) as server,
        connect(server, timeout=PATIENCE) as simulator,
        pytest.raises(SimulatorError, match="its clock does not go on"),
    ):
        fly(simulator)


def test_a_clock_that_runs_away_is_noticed():
    def fast(told):
        return told | {"timestamp": 30 * (told["timestamp"] - 1_700_000_000_000_000_000)}

    late = pytest.raises(SimulatorError, match='ms ahead of what it was asked to fly: set "ClockSpeed": 1')
    with served(altered={"getMultirotorState": fast}) as server, connect(server) as simulator, late:
        fly(simulator)


def test_a_vehicle_that_is_not_where_it_was_placed_is_noticed():
    def elsewhere(told):
        told["kinematics_estimated"]["position"]["x_val"] += 3
        return told

    lost = pytest.raises(SimulatorError, match=r"the vehicle is at \(3.0, 0.0, 5.0\), not at the start, \(0.0, 0.0, 5.0\) m")
    with served(altered={"getMultirotorState": elsewhere}) as server, lost, connect(server) as simulator:
        fly(simulator)


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats() | st.text(max_size=8) | st.binary(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=4), inner, max_size=4),
    max_leaves=12,
)


ASKED = ("ping", "listVehicles", "simGetGroundTruthEnvironment", "simIsPaused", "getMultirotorState", "isApiControlEnabled", "reset")
PLACES = ("timestamp", "kinematics_estimated", "position", "orientation", "linear_velocity", "x_val", "w_val")


def planted(told, place, value):
    """A reply with another value at every key of a name."""
    if not isinstance(told, dict):
        return told
    return {key: value if key == place else planted(part, place, value) for key, part in told.items()}


def complaint_of(**options) -> str:
    """What a flight ends with: "", or what the simulator is said to have done."""
    with served(**options) as server:
        try:
            with connect(server, timeout=0.2) as simulator:
                fly(simulator, periods=2)
        except SimulatorError as error:
            return str(error)
    return ""


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(ASKED), st.sampled_from(PLACES), VALUES)
def test_whatever_is_answered_it_is_a_flight_or_one_line(method, place, value):
    assert "\n" not in complaint_of(altered={method: lambda _: value})
    assert "\n" not in complaint_of(altered={"getMultirotorState": lambda told: planted(told, place, value)})


@settings(max_examples=20, deadline=None)
@given(st.sampled_from(ASKED), st.binary(min_size=1, max_size=30))
def test_whatever_bytes_arrive_it_is_one_line(method, raw):
    assert "\n" not in complaint_of(raw={method: raw + b"\xc1"})
