"""Spectrum and step response of the rate commands: what is put in is found again, and what cannot be told is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fake_world import make_scenario
from hotlap.report.response import LAG, density, respond, step_response
from hotlap.report.scene import trace
from plausible_world import PlausibleWorld

PERIOD = 0.01


def lagged(command, delay, constant):
    """A rate that follows its command after a delay [rows] as a first-order lag [s]."""
    rate = np.zeros(len(command))
    for t in range(1, len(rate)):
        late = command[t - 1 - delay] if t > delay else 0.0
        rate[t] = rate[t - 1] + (1 - np.exp(-PERIOD / constant)) * (late - rate[t - 1])
    return rate


def make_command(rows=900, seed=0):
    """Commands that hop now and then."""
    chance = np.random.default_rng(seed)
    return np.repeat(chance.normal(0, 3, rows // 15), 15)


def test_the_variance_is_the_sum_of_the_density():
    values = np.random.default_rng(0).standard_normal((20_000, 2)) * [1.0, 3.0]
    frequencies, power = density(values, PERIOD)
    np.testing.assert_allclose((power * frequencies[1]).sum(axis=0), [1.0, 9.0], rtol=0.05)


def test_a_line_lies_at_its_frequency():
    times = np.arange(1000) * PERIOD
    frequencies, power = density(np.sin(2 * np.pi * 12.5 * times)[:, None], PERIOD)
    assert abs(frequencies[power[:, 0].argmax()] - 12.5) < 0.4


@pytest.mark.parametrize(("delay", "constant"), [(0, 0.05), (4, 0.03), (4, 0.1)])
def test_a_lag_with_dead_time_is_found(delay, constant):
    command = make_command()
    noisy = lagged(command, delay, constant) + np.random.default_rng(1).normal(0, 0.02, len(command))
    step, deviation, explained = step_response(command, noisy, PERIOD)
    truth = lagged(np.ones(len(step) + 1), delay, constant)[:-1]
    np.testing.assert_allclose(step, truth, atol=0.06)
    assert explained > 0.99
    assert (np.abs(step - truth) <= 4 * deviation + 0.02).all()


def test_what_is_not_excited_is_uncertain():
    slow = np.sin(2 * np.pi * 0.3 * np.arange(900) * PERIOD)
    noise = np.random.default_rng(1).normal(0, 0.02, 900)
    rich = make_command()
    _, sure, _ = step_response(rich, lagged(rich, 4, 0.05) + noise, PERIOD)
    _, unsure, _ = step_response(slow, lagged(slow, 4, 0.05) + noise, PERIOD)
    assert unsure.max() > 3 * sure.max()


@pytest.mark.parametrize("command", [np.zeros(900), make_command(60)])
def test_what_cannot_be_told_is_not_a_number(command):
    step, deviation, explained = step_response(command, command, PERIOD)
    assert len(step) == round(LAG / PERIOD) + 1
    assert np.isnan([*step, *deviation, explained]).all()


def test_a_flight_has_a_response_unless_it_is_too_short():
    scenario = make_scenario()
    parameters = scenario.space.first_guess(len(scenario.segments))[None]
    flown = trace(scenario, PlausibleWorld().fly(scenario, parameters, np.zeros(1, dtype=np.int64), log=[0]), 0, "tuned")
    chance = np.random.default_rng(0)
    rates, commands = chance.standard_normal((2, len(flown.times), 4))
    found = respond(replace(flown, rates=rates[:, :3], commands=commands))
    assert found is not None
    assert found.commanded.shape == found.measured.shape == (len(found.frequencies), 3)
    assert found.steps.shape == found.deviations.shape == (len(found.lags), 3)
    assert respond(replace(flown, **{name: getattr(flown, name)[:10] for name in ("times", "rates", "commands")})) is None
