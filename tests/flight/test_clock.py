"""A controller that is not called exactly once a period estimates over the time that has passed."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from hotlap.flight.command_log import CommandLog
from hotlap.flight.controller import Controller
from hotlap.flight.observer import follow_clock, observer_numbers

from .own_plant import Drone
from .perfect_plant import Lane
from .scenarios import TUNED, make_scenario
from .test_offset_free import LOST_FROM, PERIOD, scenario_of

LOST, UNTIL = 0.15, 6.5  # share of the thrust; s
CLOCKS = {
    "jitter": lambda rng, n: PERIOD + 0.001 * rng.integers(-5, 6, n),
    "fast": lambda _, n: np.full(n, 0.005),
    "slow": lambda _, n: np.full(n, 0.015),
    "skipping": lambda rng, n: PERIOD * (1 + (rng.random(n) < 0.2)),
}
EVEN = np.full(round(UNTIL / PERIOD), PERIOD)


def estimates(steps: np.ndarray, ages: np.ndarray | None = None) -> np.ndarray:
    """Time, effectiveness, and share of the commanded thrust that acts, from a loss of thrust on, shape (n, 3).

    The last has the part of the disturbance that acts along the thrust: at a steady thrust the two cannot be told apart.
    """
    scenario, ages = scenario_of(), np.zeros(len(steps)) if ages is None else ages
    start = scenario.reference.table[0]
    drone = Drone(start[:3], start[7:10], Rotation.from_quat(np.roll(start[3:7], -1)), lost=LOST, lost_from=LOST_FROM)
    controller, found, time, seen = Controller(scenario, np.array(TUNED)), [], 0.0, []
    for step, age in zip(steps, ages, strict=True):
        seen.append((time, drone.state))
        then, state = min(seen[-4:], key=lambda one: abs(time - age - one[0]))
        command = controller.command(time, state, time - then)
        if time > LOST_FROM - 0.02:
            along = controller.disturbance @ drone.attitude.apply([0.0, 0.0, 1.0])
            found.append((time, controller.thrust_effectiveness, controller.thrust_effectiveness + along / command[0]))
        drone.fly(command, step)
        time += step
    return np.array(found)


def settled(found: np.ndarray) -> np.ndarray:
    """The estimates a second after the loss."""
    return found[found[:, 0] > LOST_FROM + 1.0, 1:]


def learnt(found: np.ndarray) -> np.ndarray:
    """The effectiveness while it is learnt."""
    return np.interp(LOST_FROM + 0.05 * np.arange(1, 9), found[:, 0], found[:, 1])


@pytest.fixture(scope="module")
def exact() -> np.ndarray:
    """What is estimated with exact periods."""
    return estimates(EVEN)


@pytest.mark.parametrize("clock", CLOCKS)
def test_a_loss_of_thrust_is_found_alike_by_every_clock(exact, clock):
    steps = CLOCKS[clock](np.random.default_rng(0), 2000)
    uneven = estimates(steps[np.cumsum(steps) < UNTIL])
    assert settled(exact)[:, 1].mean() == pytest.approx(1 - LOST, abs=0.01)
    assert_allclose(settled(uneven).mean(axis=0), settled(exact).mean(axis=0), atol=0.005)
    assert (settled(uneven).std(axis=0) < settled(exact).std(axis=0) + 0.005).all()
    assert_allclose(learnt(uneven), learnt(exact), atol=0.002)


def test_states_of_a_changing_age_teach_the_same(exact):
    late = estimates(EVEN, PERIOD * np.random.default_rng(1).integers(0, 3, len(EVEN)))
    assert_allclose(settled(late).mean(axis=0), settled(exact).mean(axis=0), atol=0.01)
    assert (settled(late).std(axis=0) < settled(exact).std(axis=0) + 0.005).all()


@pytest.mark.parametrize("elapsed", [0.004, 0.01, 0.017])
def test_gains_are_those_of_the_time_that_has_passed(elapsed):
    scenario = scenario_of()
    lane, bandwidth = Lane(scenario, np.array(TUNED)), 10.0
    follow_clock(lane.loop, scenario.race, elapsed)
    remembered = np.exp(-bandwidth * elapsed)
    expected = [elapsed, 1 - remembered**2, (1 - remembered) ** 2 / elapsed, (1 - remembered) ** 2 / elapsed]
    assert_allclose(lane.loop.observer[[0, 4, 5, 6], 0], expected)
    up, down = (1 - np.exp(-elapsed / time) for time in scenario.race.control_model.motor_time)
    assert_allclose(lane.loop.observer[[7, 8], 0], [up, down])
    assert_array_equal(observer_numbers(scenario.race, scenario.race.controller.period), observer_numbers(scenario.race))


def log_of(commands: np.ndarray, spans: np.ndarray) -> tuple[CommandLog, np.ndarray]:
    """A log to which commands were given, each for a time [s]; and its history."""
    history = np.zeros((len(commands) + 2, 4))
    log = CommandLog(history, PERIOD)
    for i, command in enumerate(commands):
        if i:
            log.lay_out(settings(), spans[i - 1], 0.0, PERIOD)
        history[0] = command
        log.keep()
    return log, history


def settings():
    """Of the small race."""
    return Lane(make_scenario(), np.array(TUNED)).settings


def test_commands_of_even_steps_are_laid_out_as_they_were_given():
    commands = np.random.default_rng(2).normal(size=(6, 4))
    log, history = log_of(commands, np.full(6, PERIOD))
    told = log.lay_out(settings(), PERIOD, 0.025, PERIOD)
    assert_array_equal(history[:6], commands[::-1])
    assert (told.acted_periods, told.acted_rest) == (2, pytest.approx(0.5))


def test_commands_of_uneven_steps_are_those_that_acted_in_each_period():
    """Against the commands looked up every 0.1 ms."""
    rng = np.random.default_rng(3)
    commands, spans = rng.normal(size=(20, 4)), 0.001 * rng.integers(5, 16, 20)
    log, history = log_of(commands, spans)
    told = log.lay_out(settings(), float(spans[-1]), 0.0235, 0.013)
    before_now = 0.0001 * np.arange(3000) + 0.00005
    starts = np.concatenate([[0.0], np.cumsum(spans[::-1])])
    acted = commands[::-1][np.minimum(np.searchsorted(starts, before_now) - 1, 19)]
    assert_allclose(history[:10], acted[:1000].reshape(10, 100, 4).mean(axis=1), atol=1e-9)
    assert_allclose(history[told.acted_periods], acted[235:365].mean(axis=0), atol=1e-9)
