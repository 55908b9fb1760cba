"""A control step takes the state seen to a command; the same code runs in an interpreter."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.flight.fly import prepare, settings_of
from hotlap.flight.job import Job
from hotlap.flight.numbers import Numbers
from hotlap.flight.segment_switch import BY_DISTANCE, BY_NODE, FRESH

from . import controls, scenarios

PERIOD = 0.01


def make_job(first: tuple[float, ...] = scenarios.TUNED, second: tuple[float, ...] = scenarios.TUNED) -> Job:
    """One flight over the small scenario, with parameters for both segments."""
    values = np.array([[first, second]])
    return prepare(scenarios.make_scenario(), values, np.zeros(1, dtype=np.int64), Numbers.FLOAT64, None, ())[0]


def test_it_begins_hovering():
    job, (mpc, loop) = make_job(), controls.allocate(5)
    mpc.low[:], mpc.high[:], loop.history[:] = 7.0, 7.0, 7.0
    controls.begin(job, controls.settings(), mpc, loop)
    assert_array_equal(loop.history[..., 0], np.tile([9.81, 0, 0, 0], (3, 1)))
    assert_array_equal(mpc.low[:, 0], controls.LOW)
    assert_array_equal(mpc.high[:, 0], controls.HIGH)


def test_the_first_plan_is_the_reference():
    job, (mpc, loop) = make_job(), controls.allocate(5)
    assert controls.aim_step(job, controls.settings(), mpc, loop, FRESH, 0.4, PERIOD) == 0
    spacing = 6.0 * 0.5 / 20
    times = 0.4 + spacing * np.arange(6)
    assert_allclose(mpc.reference[:, :3, 0], scenarios.make_reference().position_at(times), atol=1e-12)
    assert_array_equal(mpc.X[..., 0], mpc.reference[:, :10, 0])
    assert_array_equal(mpc.weights[..., 0], np.tile(scenarios.TUNED[:4], (6, 1)))
    assert mpc.spacing[0, 0] == pytest.approx(spacing)
    assert loop.shift[0, 0] == 0.0


def test_the_plan_moves_on_by_the_time_that_passed():
    job, (mpc, loop) = make_job(), controls.allocate(5)
    controls.aim_step(job, controls.settings(), mpc, loop, FRESH, 0.4, PERIOD)
    before = mpc.X.copy()
    controls.aim_step(job, controls.settings(), mpc, loop, 0, 0.41, PERIOD)
    assert loop.shift[0, 0] == pytest.approx(PERIOD / 0.15)
    assert_array_equal(mpc.X, before)
    controls.aim_step(job, controls.settings(), mpc, loop, 0, 0.9, 0.5)
    assert loop.shift[0, 0] == 1.0  # never beyond the next node


def test_another_segment_has_its_own_weights_and_spacing():
    other = (100.0, 200.0, 30.0, 4.0, 2.0)
    job, (mpc, loop) = make_job(second=other), controls.allocate(5)
    controls.aim_step(job, controls.settings(), mpc, loop, FRESH, scenarios.BORDER - PERIOD, PERIOD)
    plan = mpc.X[..., 0].copy()
    assert controls.aim_step(job, controls.settings(), mpc, loop, 0, scenarios.BORDER, PERIOD) == 1
    assert_array_equal(mpc.weights[..., 0], np.tile(other[:4], (6, 1)))
    assert mpc.spacing[0, 0] == pytest.approx(0.05)
    assert loop.shift[0, 0] == 0.0
    times = PERIOD + 0.05 * np.arange(6)
    assert_allclose(mpc.X[:, 0, 0], np.interp(times, 0.15 * np.arange(6), plan[:, 0]), atol=1e-12)


def test_each_node_may_have_the_weights_of_its_own_segment():
    other = (100.0, 200.0, 30.0, 4.0, 2.0)
    job, (mpc, loop) = make_job(second=other), controls.allocate(5)
    by_node = controls.settings(segment_switch=BY_NODE)
    assert controls.aim_step(job, by_node, mpc, loop, FRESH, scenarios.BORDER - 0.4, PERIOD) == 0
    assert mpc.spacing[0, 0] == pytest.approx(0.15)  # of the segment that the first node is in
    assert_array_equal(mpc.weights[..., 0], [scenarios.TUNED[:4]] * 3 + [other[:4]] * 3)
    controls.aim_step(job, by_node, mpc, loop, 0, scenarios.BORDER - 0.25, 0.15)
    assert_array_equal(mpc.weights[..., 0], [scenarios.TUNED[:4]] * 2 + [other[:4]] * 4)


def test_the_drone_may_have_to_come_close_before_the_next_segment_begins():
    other = (100.0, 200.0, 30.0, 4.0, 2.0)
    job, (mpc, loop) = make_job(second=other), controls.allocate(5)
    near = controls.settings(segment_switch=BY_DISTANCE, segment_switch_distance=1.0)
    border = scenarios.make_reference().position_at(np.array([scenarios.BORDER]))[0]
    loop.seen[:3, 0] = border
    assert controls.aim_step(job, near, mpc, loop, FRESH, 0.0, PERIOD) == 0  # a flight begins with the first
    loop.seen[:3, 0] = border + [0.8, 0.0, 0.7]
    assert controls.aim_step(job, near, mpc, loop, 0, scenarios.BORDER + 1.0, PERIOD) == 0
    loop.seen[:3, 0] = border + [0.7, 0.0, 0.7]
    assert controls.aim_step(job, near, mpc, loop, 0, 0.5, PERIOD) == 1
    assert_array_equal(mpc.weights[..., 0], np.tile(other[:4], (6, 1)))
    loop.seen[:3, 0] = border + 5.0
    assert controls.aim_step(job, near, mpc, loop, 1, 0.6, PERIOD) == 1  # and never goes back


def test_a_lead_looks_ahead_for_reference_and_segment():
    job, (mpc, loop) = make_job(), controls.allocate(5)
    assert controls.aim_step(job, controls.settings(lead=0.05), mpc, loop, FRESH, scenarios.BORDER - 0.03, PERIOD) == 1
    assert_allclose(mpc.reference[0, :3, 0], scenarios.make_reference().position_at(np.array([scenarios.BORDER + 0.02]))[0], atol=1e-12)


def test_without_feed_forward_it_is_to_stay_close_to_hover():
    job, (mpc, loop) = make_job(), controls.allocate(5)
    controls.aim_step(job, controls.settings(feed_forward=False), mpc, loop, FRESH, 0.4, PERIOD)
    assert_array_equal(mpc.reference[:, 10:, 0], np.tile([9.81, 0, 0, 0], (6, 1)))


def test_commands_are_remembered_the_newest_first():
    job, (mpc, loop) = make_job(), controls.allocate(5)
    controls.aim_step(job, controls.settings(), mpc, loop, FRESH, 0.4, PERIOD)
    loop.seen[:], loop.history[:] = mpc.X[0], np.arange(12.0).reshape(3, 4, 1)
    controls.control_step(controls.settings(), mpc, loop)
    assert_array_equal(loop.history[0, :, 0], mpc.U[0, :, 0])
    assert_array_equal(loop.history[1:, :, 0], np.arange(8.0).reshape(2, 4))


@pytest.mark.parametrize(("periods", "rest"), [(0, 0.0), (0, 0.0075), (2, 0.0), (3, 0.005)])
def test_the_state_is_predicted_through_the_commands_on_their_way(periods, rest):
    mpc, loop = controls.allocate(5, commands=6)
    rng = np.random.default_rng(1)
    history = np.array([9.81, 0, 0, 0]) + rng.normal(size=(6, 4))
    start = controls.stages.draw_state(rng)
    mpc.X[..., 0], loop.seen[:, 0], loop.history[..., 0] = start, start, history
    controls.control_step(controls.settings(predicted_periods=periods, predicted_rest=rest), mpc, loop)
    expected = controls.roll_out(start, history[periods][None], rest)[-1]
    for k in range(periods - 1, -1, -1):  # the oldest acts first
        expected = controls.roll_out(expected, history[k][None], PERIOD)[-1]
    assert_allclose(mpc.X[0, :, 0], expected, atol=1e-12)


@pytest.fixture(scope="module")
def interpreted() -> list[list[float]]:
    """Three control steps that end in each segment, in a process without a compiler."""
    tests = Path(__file__).parents[1]
    program = "import json; from flight import controls; print(json.dumps([controls.three_steps(segment) for segment in (0, 1)]))"
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run([sys.executable, "-c", program], cwd=tests, env=environment, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


@pytest.mark.parametrize("segment", [0, 1])
def test_without_a_compiler_it_does_the_same(segment, interpreted):
    """Three control steps, across the border between the segments or not."""
    assert_allclose(interpreted[segment], controls.three_steps(segment), rtol=1e-9, atol=1e-9)


def test_settings_are_those_of_the_race():
    noisy = scenarios.make_scenario(model={"delay": 0.0475}, noise={"thrust": 0.02, "time": 0.1, "wind": 0.3}, controller={"sweeps": 4})
    s = settings_of(noisy)
    assert (s.sweeps, s.steps, s.gravity, s.wind, s.thrust_noise) == (4, 4, 9.81, 0.3, 0.02)
    assert (s.predicted_periods, s.predicted_rest, s.lead) == (4, pytest.approx(0.0075), 0.0475)
    assert s.noise_memory == pytest.approx(np.exp(-0.1))
    now = settings_of(scenarios.make_scenario(model={"delay": 0.0475}, controller={"reference_time": "now"}))
    assert (now.lead, now.predicted_periods) == (0.0, 4)
    blind = settings_of(scenarios.make_scenario(model={"delay": 0.0475}, controller={"predict": False}))
    assert (blind.lead, blind.predicted_periods, blind.predicted_rest) == (0.0, 0, 0.0)
    whole = settings_of(scenarios.make_scenario(model={"delay": 0.05}))
    assert (whole.predicted_periods, whole.predicted_rest) == (5, 0.0)
