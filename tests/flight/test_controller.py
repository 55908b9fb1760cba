"""The controller by itself commands what it commands in flight."""

import numpy as np
import pytest

from flight.scenarios import TUNED, fly, make_scenario
from hotlap.core.errors import HotlapError
from hotlap.flight.controller import Controller

DELAYED = make_scenario({"delay": 0.0475}, model={"delay": 0.0475}, noise={"position": 0.05, "rates": 0.1})


@pytest.mark.parametrize("scenario", [make_scenario(), DELAYED])
def test_it_repeats_a_flight(scenario):
    log = fly(scenario, 1, numbers="float64", log=[0]).logs[0]
    controller = Controller(scenario, np.array(TUNED))
    commands = [controller.command(time, state) for time, state in zip(log.times[:-1], log.states[:-1], strict=True)]
    np.testing.assert_allclose(commands, log.commands[:-1], rtol=0, atol=1e-12)


def test_after_a_reset_it_begins_again():
    scenario = make_scenario()
    controller, state = Controller(scenario, np.array(TUNED)), scenario.reference.table[0, :10]
    first = controller.command(0.0, state)
    controller.command(0.01, state)
    controller.reset()
    np.testing.assert_array_equal(controller.command(0.0, state), first)


def test_both_quaternions_of_an_attitude_are_one():
    scenario = make_scenario()
    state = scenario.reference.table[50, :10].copy()
    first = Controller(scenario, np.array(TUNED)).command(0.5, state)
    state[3:7] *= -1
    np.testing.assert_array_equal(Controller(scenario, np.array(TUNED)).command(0.5, state), first)


def test_an_old_state_is_predicted_through_the_commands_given_since():
    """A state as old as the dead time that is known has the same command as a dead time twice as long with a fresh one."""
    once, twice = make_scenario(model={"delay": 0.03}), make_scenario(model={"delay": 0.06})
    old, fresh = Controller(once, np.array(TUNED)), Controller(twice, np.array(TUNED))
    states = once.reference.table
    old._settings = old._settings._replace(lead=0.06)  # the reference ahead is that of the dead time alone
    for tick in range(60):
        time = 0.01 * tick
        np.testing.assert_allclose(old.command(time, states[tick, :10], age=0.03), fresh.command(time, states[tick, :10]), atol=1e-12)


@pytest.mark.parametrize("time", [0.5, 0.4, np.nan, np.inf])
def test_time_goes_on(time):
    scenario = make_scenario()
    controller, state = Controller(scenario, np.array(TUNED)), scenario.reference.table[0, :10]
    controller.command(0.5, state)
    with pytest.raises(HotlapError, match="time must go on"):
        controller.command(time, state)


@pytest.mark.parametrize("state", [np.full(10, np.nan), np.ones(9)])
def test_a_state_that_is_none_is_refused(state):
    with pytest.raises(HotlapError, match="ten finite numbers"):
        Controller(make_scenario(), np.array(TUNED)).command(0.0, state)


def test_an_age_out_of_range_is_refused():
    with pytest.raises(HotlapError, match="age of a state"):
        Controller(make_scenario(), np.array(TUNED)).command(0.0, np.ones(10), age=0.3)
