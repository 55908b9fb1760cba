"""The geometric controller tilts its thrust against errors, and flies in the same kernel."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flight.scenarios import fly, make_reference, make_scenario
from hotlap.core.records import End
from hotlap.flight.controller import Controller
from hotlap.flight.geometric import steering_stage
from hotlap.flight.program import run
from hotlap.race.controllers import TUNABLE, ControllerKind
from hotlap.reference.scenario import Scenario

GAINS = np.array(TUNABLE[ControllerKind.GEOMETRIC].default)
WIDE, PROGRAM = np.full(4, 1e3), steering_stage()
LEVEL = np.array([0.0, 0, 0, 1, 0, 0, 0, 0, 0, 0])
HOVER = np.array([*LEVEL, 9.81, 0, 0, 0])


def steer(state, reference=HOVER, acceleration=(0, 0, 0), gains=GAINS, low=-WIDE, high=WIDE):
    command = np.zeros(4)
    run(PROGRAM, [np.asarray(a, dtype=float) for a in (state, reference, acceleration, gains, low, high, [9.81])] + [command])
    return command


def geometric(vehicle=None, **changes) -> Scenario:
    scenario = make_scenario(vehicle, **changes)
    return Scenario(scenario.race.with_controller(ControllerKind.GEOMETRIC), scenario.reference, scenario.segments)


def test_on_its_reference_it_commands_the_reference():
    np.testing.assert_allclose(steer(LEVEL), [9.81, 0, 0, 0], atol=1e-12)
    table = make_reference()
    for row in (60, 150, 220):
        acceleration = (table.velocity[row + 1] - table.velocity[row - 1]) / 0.02
        command = steer(table.table[row, :10], table.table[row], acceleration)
        np.testing.assert_allclose(command, table.table[row, 10:], atol=0.02)


@pytest.mark.parametrize(
    ("error", "index", "sign"),
    [((-1, 0, 0), 2, 1), ((0, -1, 0), 1, -1), ((0, 0, -1), 0, 1)],  # too far back: pitch forward; too far right: roll left; too low: rise
)
def test_it_tilts_against_a_position_error(error, index, sign):
    state = LEVEL.copy()
    state[:3] = error
    change = steer(state) - [9.81, 0, 0, 0]
    assert change[index] * sign > 1
    np.testing.assert_allclose(np.delete(change, [0, index]), 0, atol=1e-12)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_it_turns_back_from_an_attitude_error_in_proportion(axis):
    turn = np.zeros(3)
    turn[axis] = 0.1
    state = LEVEL.copy()
    state[3:7] = np.roll(Rotation.from_rotvec(turn).as_quat(), 1)
    command = steer(state)
    expected = np.zeros(3)
    expected[axis] = -GAINS[4 if axis < 2 else 5] * 2 * np.sin(0.05)
    np.testing.assert_allclose(command[1:], expected, atol=1e-12)


def test_both_quaternions_of_an_attitude_are_one():
    state = LEVEL.copy()
    state[3:7] = np.roll(Rotation.from_rotvec([0.3, -0.2, 0.5]).as_quat(), 1)
    other = state.copy()
    other[3:7] *= -1
    np.testing.assert_allclose(steer(state), steer(other), atol=1e-12)


def test_the_command_does_not_depend_on_where_north_is():
    rng = np.random.default_rng(2)
    state, reference = LEVEL + 0.2 * rng.standard_normal(10), HOVER + 0.2 * rng.standard_normal(14)
    acceleration = rng.standard_normal(3)
    for vector in (state, reference):
        vector[3:7] /= np.linalg.norm(vector[3:7])
    north = Rotation.from_euler("z", 1.1)

    def turned(vector):
        after = vector.copy()
        after[:3], after[7:10] = north.apply(vector[:3]), north.apply(vector[7:10])
        after[3:7] = np.roll((north * Rotation.from_quat(np.roll(vector[3:7], -1))).as_quat(), 1)
        return after

    np.testing.assert_allclose(steer(turned(state), turned(reference), north.apply(acceleration)), steer(state, reference, acceleration))


def test_commands_keep_their_bounds_even_upside_down():
    state = LEVEL.copy()
    state[3:7], state[:3] = (0, 1, 0, 0), (9, -9, 9)
    low, high = np.array([1.0, -3, -3, -1]), np.array([12.0, 3, 3, 1])
    command = steer(state, low=low, high=high)
    assert np.isfinite(command).all()
    assert ((low <= command) & (command <= high)).all()


@pytest.mark.check
def test_it_flies_and_its_lanes_fly_as_plain_floats_do():
    scenario = geometric(noise={"position": 0.05, "thrust": 0.02, "rates": 0.1})
    asked = np.tile(GAINS, (9, 2, 1))
    lanes, scalar = (fly(scenario, asked, numbers=kind) for kind in ("", "float64"))
    assert (lanes.end == End.FINISHED).all()
    np.testing.assert_allclose(lanes.mean_error, scalar.mean_error, rtol=1e-4)
    assert fly(scenario, asked[:1], seeds=[4]).mean_error[0] == lanes.mean_error[4]


@pytest.mark.check
def test_by_itself_it_repeats_a_flight():
    scenario = geometric({"delay": 0.03}, model={"delay": 0.03})
    log = fly(scenario, np.tile(GAINS, (1, 2, 1)), numbers="float64", log=[0]).logs[0]
    controller = Controller(scenario, GAINS)
    commands = [controller.command(time, state) for time, state in zip(log.times[:-1], log.states[:-1], strict=True)]
    np.testing.assert_allclose(commands, log.commands[:-1], rtol=0, atol=1e-12)
