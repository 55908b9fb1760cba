"""What every simulator keeps to: subclass `SimulatorContract` in the test file of a simulator, and say how one is made.

    class TestMine(SimulatorContract):
        def make(self, quadrotor):
            return MySimulator(quadrotor)

Tolerances are attributes, to be widened with a word on why.
"""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
import pytest

from flight.scenarios import make_scenario, parameters
from hotlap.race.quadrotor import Quadrotor
from hotlap.reference.scenario import Scenario
from hotlap.worlds.simulator import Simulator, SimulatorError, Start
from hotlap.worlds.stepped import Stepped

LEVEL = (1.0, 0.0, 0.0, 0.0)
HIGH = (1.0, -2.0, 8.0)  # m, where drones are placed
PLAIN = Quadrotor(
    name="plain",
    mass=0.8,
    inertia=(0.003, 0.003, 0.005),
    arm=0.15,
    rotor_thrust=(0.0, 6.0),
    torque_ratio=0.016,
    motor_time=(0.02, 0.02),
)


def turned(axis: int, angle: float) -> np.ndarray:
    """The attitude of a rotation about an axis of the world, (w, x, y, z)."""
    attitude = np.zeros(4)
    attitude[0], attitude[1 + axis] = math.cos(angle / 2), math.sin(angle / 2)
    return attitude


def placed(attitude: Any = LEVEL, velocity: Any = (0.0, 0.0, 0.0)) -> np.ndarray:
    """The state of a drone high up that does not turn."""
    return np.concatenate([HIGH, attitude, velocity, np.zeros(3)])


class SimulatorContract:
    """Tests of a simulator in all of its lanes.

    Attributes:
        quadrotor: that is flown.
        scenario: that is flown whole; its vehicle is the quadrotor of that flight.
        place: [m], [m/s], [-] by which a drone may be off where it was placed.
        drift: [m] that it may move in a second of hovering.
        same: [m] by which two flights may differ that were begun alike.
        fall: share of gravity by which a drone without thrust may fall slower or faster.
        timeout: [s] after which a lost simulator must have said so.
    """

    quadrotor: Quadrotor = PLAIN
    scenario: Scenario = make_scenario(noise={"thrust": 0.02, "rates": 0.1, "thrust_bias": 0.01, "position": 0.05, "velocity": 0.05})
    place, drift, same, fall, timeout = 1e-6, 0.05, 1e-9, 0.15, 60.0

    def make(self, quadrotor: Quadrotor) -> Simulator:
        """A simulator of a quadrotor, just opened."""
        raise NotImplementedError

    def lose(self, simulator: Simulator) -> None:  # noqa: ARG002
        """Cut the connection, or kill the program, behind its back."""
        pytest.skip("it runs in this process")

    @pytest.fixture(scope="class")
    @classmethod
    def simulator(cls):
        """One for all tests of a class."""
        opened = cls().make(cls.quadrotor)
        yield opened
        opened.close()

    def begin(self, simulator: Simulator, state: np.ndarray, factor: float = 1.0) -> None:
        """Place the drones of all lanes."""
        for lane in range(simulator.lanes):
            simulator.reset(lane, Start(state, factor))

    def fly(self, simulator: Simulator, duration: float, *, thrust: float | None = None, rates: Any = (0.0, 0.0, 0.0)) -> np.ndarray:
        """Fly all lanes under one command, in periods of about 10 ms; the states then."""
        command = np.array([self.quadrotor.gravity if thrust is None else thrust, *rates])
        steps, period = round(duration / simulator.step), max(1, round(0.01 / simulator.step))
        while steps > 0:
            simulator.advance(np.tile(command, (simulator.lanes, 1)), min(period, steps) * simulator.step)
            steps -= period
        return np.array(simulator.states())

    def test_it_says_what_it_is(self, simulator):
        assert simulator.lanes >= 1
        assert 0 < simulator.step <= 0.01
        assert simulator.scales_thrust in {True, False}
        self.begin(simulator, placed())
        assert np.shape(simulator.states()) == (simulator.lanes, 13)
        assert np.shape(simulator.rotor_thrusts()) == (simulator.lanes, 4)

    @pytest.mark.parametrize(
        "attitude", [LEVEL, turned(0, 0.5), turned(1, -0.4), turned(2, 2.0)], ids=["level", "rolled", "pitched", "yawed"]
    )
    def test_a_drone_is_where_it_was_placed(self, simulator, attitude):
        """Also the order of the quaternion's parts, and which way it turns."""
        state = placed(attitude, (2.0, -1.0, 0.5))
        self.begin(simulator, state)
        for found in np.array(simulator.states()):
            found[3:7] *= np.sign(found[3:7] @ state[3:7])
            np.testing.assert_allclose(found[:10], state[:10], atol=self.place)
            np.testing.assert_allclose(found[10:], 0, atol=max(self.place, 1e-3))

    def test_hover_holds(self, simulator):
        self.begin(simulator, placed())
        states = self.fly(simulator, 1.0)
        assert np.linalg.norm(states[:, :3] - HIGH, axis=1).max() < self.drift
        assert np.abs(states[:, 4:6]).max() < 0.05

    def test_rotors_are_told_in_newtons_or_not_at_all(self, simulator):
        self.begin(simulator, placed())
        self.fly(simulator, 0.5)
        thrusts = np.array(simulator.rotor_thrusts())
        assert np.isnan(thrusts).all() or thrusts.sum(axis=1) == pytest.approx(self.quadrotor.mass * self.quadrotor.gravity, rel=0.05)

    @pytest.mark.parametrize("axis", [0, 1, 2], ids=["roll", "pitch", "yaw"])
    @pytest.mark.parametrize("sign", [1.0, -1.0])
    def test_a_rate_turns_the_right_way(self, simulator, axis, sign):
        self.begin(simulator, placed())
        states = self.fly(simulator, 0.3, rates=sign * np.eye(3)[axis])
        rates, others = states[:, 10 + axis] * sign, np.delete(states[:, 10:13], axis, axis=1)
        assert (rates > 0.4).all()
        assert (rates < 1.6).all()
        assert np.abs(others).max() < 0.25
        states[:, 3:7] *= np.sign(states[:, 3:4])
        assert (sign * states[:, 4 + axis] > 0.05).all()

    def test_rates_are_those_of_the_body(self, simulator):
        """A drone on its side that yaws turns about a level axis of the world."""
        self.begin(simulator, placed(turned(0, math.pi / 2)))
        states = self.fly(simulator, 0.3, rates=(0.0, 0.0, 1.0))
        assert (states[:, 12] > 0.4).all()
        assert np.abs(states[:, 10:12]).max() < 0.25

    def test_more_thrust_climbs_as_fast_as_was_asked_for(self, simulator):
        self.begin(simulator, placed())
        before = self.fly(simulator, 0.2, thrust=self.quadrotor.gravity + 3)[:, 9]
        gained = self.fly(simulator, 0.2, thrust=self.quadrotor.gravity + 3)[:, 9] - before
        assert gained == pytest.approx(0.6, rel=0.2)

    def test_without_thrust_it_falls_freely(self, simulator):
        self.begin(simulator, placed())
        before = self.fly(simulator, 0.2, thrust=0.0)[:, 9]
        lost = before - self.fly(simulator, 0.2, thrust=0.0)[:, 9]
        assert lost == pytest.approx(0.2 * self.quadrotor.gravity, rel=self.fall)

    @pytest.mark.parametrize(
        ("attitude", "direction"),
        [
            (turned(1, 0.3), (1.0, 0.0)),
            (turned(0, 0.3), (0.0, -1.0)),
            (np.array([1.0, -1.0, 1.0, 1.0]) / 2, (0.0, 1.0)),
        ],
        ids=["nose down flies forward", "to the right flies right", "nose down flies left where that is forward"],
    )
    def test_a_drone_flies_where_its_thrust_points(self, simulator, attitude, direction):
        """World: x forward, y left, z up. The third has yawed to the left by 90 degrees, and leans forward all the way."""
        self.begin(simulator, placed(attitude))
        velocity = self.fly(simulator, 0.2)[:, 7:9]
        assert (velocity @ np.array(direction) > 0.3).all()
        assert np.abs(velocity @ np.array([-direction[1], direction[0]])).max() < 0.15

    def test_velocity_is_that_of_the_world(self, simulator):
        self.begin(simulator, placed(turned(2, math.pi / 2), (2.0, 0.0, 0.0)))
        moved = self.fly(simulator, 0.1)[:, :3] - HIGH
        np.testing.assert_allclose(moved, np.tile([0.2, 0.0, 0.0], (simulator.lanes, 1)), atol=0.03)

    def test_a_reset_forgets_everything(self, simulator):
        self.begin(simulator, placed())
        first = self.fly(simulator, 0.3, rates=(0.5, 0.2, 0.1))
        self.fly(simulator, 0.4, thrust=15.0, rates=(-2.0, 1.0, 1.0))
        self.begin(simulator, placed())
        again = self.fly(simulator, 0.3, rates=(0.5, 0.2, 0.1))
        np.testing.assert_allclose(again[:, :3], first[:, :3], atol=self.same)

    def test_a_reset_leaves_other_lanes_as_they_are(self, simulator):
        if simulator.lanes == 1:
            pytest.skip("it has one lane")
        self.begin(simulator, placed())
        before = self.fly(simulator, 0.2, thrust=12.0)
        simulator.reset(0, Start(placed(turned(2, 1.0))))
        np.testing.assert_allclose(np.array(simulator.states())[1:], before[1:], atol=1e-9)
        after = self.fly(simulator, 0.2)
        assert np.abs(after[0, 7:10]).max() < 0.2
        assert (after[1:, 9] > 0.2).all()

    def test_a_thrust_factor_is_heeded_where_it_is_said_to_be(self, simulator):
        if not simulator.scales_thrust:
            pytest.skip("the world multiplies its commands")
        self.begin(simulator, placed(), factor=1.1)
        assert self.fly(simulator, 0.4)[:, 9] == pytest.approx(0.04 * self.quadrotor.gravity, rel=0.3)

    def test_the_same_seeds_fly_the_same_flights(self):
        opened = []

        def open_one(scenario: Scenario, _instance: int) -> Simulator:
            opened.append(self.make(scenario.race.vehicle))
            return opened[-1]

        world, asked = Stepped("contract", open_one), parameters(3)
        try:
            first, again = (world.fly(self.scenario, asked, np.array([4, 5, 4]), log=[0]) for _ in range(2))
        finally:
            world.close()
        np.testing.assert_allclose(again.max_error, first.max_error, atol=self.same)
        assert first.max_error[2] == pytest.approx(first.max_error[0], abs=self.same)
        assert abs(first.max_error[1] - first.max_error[0]) > self.same
        assert first.end_time.min() > 0.5
        assert len(opened) == 1

    def test_it_may_be_closed_twice(self):
        simulator = self.make(self.quadrotor)
        simulator.close()
        simulator.close()

    def test_a_lost_simulator_says_so(self):
        simulator = self.make(self.quadrotor)
        try:
            self.begin(simulator, placed())
            self.fly(simulator, 0.05)
            self.lose(simulator)
            begun = time.monotonic()
            with pytest.raises(SimulatorError) as lost:
                self.fly(simulator, 1.0)
            assert time.monotonic() - begun < self.timeout
            assert "\n" not in str(lost.value)
        finally:
            simulator.close()
