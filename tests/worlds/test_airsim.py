"""AirSim's quadrotor over the wire, against a server that flies our plant and notes what the real one would not survive."""

from __future__ import annotations

import socket
import threading
from contextlib import closing, contextmanager

import msgpack
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hotlap.core.errors import InputError
from hotlap.files.descriptions import load_quadrotor
from hotlap.importers.content import Content
from hotlap.worlds.airsim import open_simulator
from hotlap.worlds.airsim.address import Address, address_of
from hotlap.worlds.airsim.client import Client
from hotlap.worlds.airsim.frames import kinematics_of, rotation_of, state_of
from hotlap.worlds.airsim.simulator import STEP, AirSim
from hotlap.worlds.simulator import SimulatorError, Start
from worlds.airsim_plant import Plant
from worlds.airsim_server import Server

VEHICLE = load_quadrotor("airsim-122m")
HOVER = np.array([[9.80665, 0.0, 0.0, 0.0]])
START = Start(np.array([1.0, 2.0, 3.0, 0.5, 0.5, 0.5, 0.5, 0.3, 0.2, 0.1, 0.3, 0.2, 0.1]))
LEVEL = Start(np.array([0.0, 0.0, 5.0, 1.0, *(0.0,) * 9]))
PATIENCE = 1.0  # s, of tests in which nobody answers


def served(**options) -> Server:
    return Server(Plant(VEHICLE, delayed=False), **options)


def connect(server: Server, vehicle: str = "", timeout: float = 5.0) -> closing[AirSim]:
    return closing(open_simulator(None, 0, f"127.0.0.1:{server.port}:{vehicle}", timeout))


def fly(simulator: AirSim, start: Start = LEVEL, periods: int = 40) -> None:
    simulator.reset(0, start)
    for k in range(periods):
        simulator.advance(HOVER, (3 + (k % 3 == 0)) * STEP)


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


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("", Address("127.0.0.1", 41451, "")),
        ("sim.local", Address("sim.local", 41451, "")),
        ("10.0.0.2:5000", Address("10.0.0.2", 5000, "")),
        (":5000:Drone:1", Address("127.0.0.1", 5000, "Drone:1")),
    ],
)
def test_an_address_is_read_as_far_as_it_is_written(text, address):
    assert address_of(text) == address


@pytest.mark.parametrize("text", ["host:", "host:0", "host:-1", "host:65536", "host:port", "host:١"])
def test_a_port_that_is_none_is_refused(text):
    if text == "host:":
        assert address_of(text).port == 41451
    else:
        with pytest.raises(InputError, match=r"^on: the port must be a number from 1 to 65535, not"):
            open_simulator(None, 0, text)


def test_every_instance_has_a_port_of_its_own():
    assert address_of("host:5000", 3).port == 5003
    with pytest.raises(InputError, match="from 1 to 65534"):
        open_simulator(None, 1, "host:65535")


def test_states_come_back_as_they_were_sent():
    np.testing.assert_allclose(state_of(Content("", kinematics_of(START.state))), START.state, atol=1e-15)


def test_frames_are_turned_and_not_mirrored():
    """A quarter of a turn to the right (north to east), 4 m up, flying east and rolling right."""
    half = np.sqrt(0.5)
    ned = {
        "position": {"x_val": 1.0, "y_val": 2.0, "z_val": -4.0},
        "orientation": {"w_val": half, "x_val": 0.0, "y_val": 0.0, "z_val": half},
        "linear_velocity": {"x_val": 0.0, "y_val": 3.0, "z_val": 0.0},
        "angular_velocity": {"x_val": 0.1, "y_val": 0.2, "z_val": 0.3},
    }
    expected = [1, -2, 4, half, 0, 0, -half, 0, -3, 0, 0.1, -0.2, -0.3]
    np.testing.assert_allclose(state_of(Content("", ned)), expected, atol=1e-15)
    rotation = rotation_of(Content("", ned)["orientation"])
    np.testing.assert_allclose(rotation.T, [[0, -1, 0], [-1, 0, 0], [0, 0, -1]], atol=1e-15)


def test_it_starts_where_it_is_placed_with_its_rotors_as_in_hover():
    with served() as server, connect(server) as simulator:
        simulator.reset(0, START)
        np.testing.assert_allclose(simulator.states()[0], START.state, atol=1e-12)
        np.testing.assert_allclose(simulator.rotor_thrusts(), np.full((1, 4), 9.80665 / 4), rtol=1e-3)
        assert server.violations == []


@pytest.mark.parametrize("density", [1.225, 1.210716, 0.9])
def test_thrust_is_what_was_commanded_however_thin_the_air(density):
    with served(density=density) as server, connect(server) as simulator:
        simulator.reset(0, LEVEL)
        simulator.advance(np.array([[8.0, 0.0, 0.0, 0.0]]), 0.03)
        simulator.advance(np.array([[0.0, 0.0, 0.0, 0.0]]), 0.03)
        full = 4 * 4.179446 * density / 1.225
        np.testing.assert_allclose(server.thrusts[-2:], [8.0, 0.06 * full], rtol=1e-6)


def test_each_rotor_is_told_in_its_place():
    """A roll to the right: the left rotors push more."""
    with served() as server, connect(server) as simulator:
        simulator.reset(0, LEVEL)
        simulator.advance(np.array([[9.81, 2.0, 0.0, 0.0]]), 0.009)
        front_left, front_right, back_right, back_left = simulator.rotor_thrusts()[0]
        assert min(front_left, back_left) > max(front_right, back_right) + 0.1
        np.testing.assert_allclose(simulator.rotor_thrusts()[0], server.plant.rotor_thrusts)


def test_time_does_not_drift_though_periods_are_too_long_or_too_short():
    with served() as server, connect(server) as simulator:
        simulator.reset(0, LEVEL)
        begun, due, worst = server.stamp, 0.0, 0.0
        for k in range(700):
            simulator.advance(HOVER, (3 + (k % 3 == 0)) * STEP)
            due += (3 + (k % 3 == 0)) * STEP
            worst = max(worst, abs(1e-9 * (server.stamp - begun) - due))
        assert {0, 3, 4} <= set(server.periods)
        assert abs(1e-9 * (server.stamp - begun) - due) <= STEP
        assert worst <= 1.6 * STEP
        assert server.holds == 0
        assert server.violations == []


def test_a_long_time_is_flown_without_losing_the_command():
    with served() as server, connect(server) as simulator:
        simulator.reset(0, LEVEL)
        simulator.advance(np.array([[9.80665, 0.0, 0.0, 0.5]]), 0.9)
        assert server.holds == 0
        assert simulator.states()[0, 12] == pytest.approx(0.5, abs=0.02)


def test_a_vehicle_without_a_goal_holds_its_position():
    """Of the stand-in: else the test above would prove nothing."""
    with served() as server, connect(server) as simulator:
        simulator.reset(0, LEVEL)
        simulator.advance(HOVER, 0.03)
        simulator._moves.stop()
        simulator._due += 0.3
        simulator._continue()
        assert server.holds > 60


@pytest.mark.parametrize("cancels_successor", [False, True])
def test_a_move_that_misses_being_replaced_is_called_off(cancels_successor):
    with served(loses_cancel=(9, 20), cancels_successor=cancels_successor) as server, connect(server) as simulator:
        fly(simulator)
        assert server.calls["cancelLastTask"] == 3  # one of them when it connected
        assert server.violations == []
        assert server.holds == 0


def test_a_client_that_does_not_wait_is_found_out():
    """Of the stand-in: what the real server does not survive is noted, and then it is silent."""
    with served(loses_cancel=(3,)) as server, connect(server, timeout=PATIENCE) as simulator:
        simulator.reset(0, LEVEL)
        for _ in range(3):
            simulator._client.send("moveByAngleRatesThrottle", 0.0, 0.0, 0.0, 0.6, 0.2, "")
        with pytest.raises(SimulatorError, match="was not answered within 1 s"):
            simulator._client.call("ping")
        assert server.violations


def test_flights_end_and_begin_again_in_order():
    with served() as server, connect(server) as simulator:
        for _ in range(3):
            fly(simulator, START, 10)
        simulator.close()
        assert server.violations == []
        assert server.calls["reset"] == 3
        assert not server.paused
        assert not server.controlled


def test_drone_racing_lab_is_flown_by_poses():
    with served(racing_lab=True) as server, connect(server) as simulator:
        fly(simulator)
        np.testing.assert_allclose(simulator.states()[0], LEVEL.state, atol=0.02)
        assert np.isnan(simulator.rotor_thrusts()).all()
        with pytest.raises(SimulatorError, match="no simSetKinematics, so a flight cannot start at 9 m/s"):
            simulator.reset(0, Start(np.array([*LEVEL.state[:7], 9.0, *(0.0,) * 5])))
        assert server.violations == []


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
