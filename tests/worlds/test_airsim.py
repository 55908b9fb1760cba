"""AirSim's quadrotor over the wire, against a server that flies our plant and notes what the real one would not survive."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.core.errors import InputError
from hotlap.files.content import Content
from hotlap.worlds.airsim import open_simulator
from hotlap.worlds.airsim.address import Address, address_of
from hotlap.worlds.airsim.frames import kinematics_of, rotation_of, state_of
from hotlap.worlds.airsim.simulator import STEP
from hotlap.worlds.simulator import SimulatorError, Start
from worlds.airsim_flights import HOVER, LEVEL, PATIENCE, START, connect, fly, served


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


@pytest.mark.parametrize("loses_cancel", [(), (3,)])
def test_a_client_that_does_not_wait_is_found_out(loses_cancel):
    """Of the stand-in: what the real server does not survive is noted, and then it is silent."""
    with served(loses_cancel=loses_cancel) as server, connect(server, timeout=PATIENCE) as simulator:
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
