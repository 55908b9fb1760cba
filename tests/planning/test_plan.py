"""A plan obeys physics and its limits, whatever the race."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from hotlap.dynamics.models import planning_model
from hotlap.planning.minimum_time import model_parameters, ramped_limits
from hotlap.reference.attitude import thrust_axis

from . import small

pytestmark = pytest.mark.parametrize("name", list(small.RACES))


def test_the_planned_inputs_fly_the_planned_path(name):
    _, problem, trajectory, _ = small.planned(name)
    model, parameters, times = planning_model(), model_parameters(problem), trajectory.times
    state = trajectory.states[0]
    for control, begin, end in zip(trajectory.controls, times[:-1], times[1:], strict=True):

        def derivative(_, state, control=control):
            return np.asarray(model(state, control, parameters)).ravel()

        state = solve_ivp(derivative, (begin, end), state, rtol=1e-8, atol=1e-9).y[:, -1]
    assert_allclose(state[:3], trajectory.states[-1, :3], atol=0.02)


def test_rows_obey_the_equations_of_motion(name):
    _, problem, trajectory, reference = small.planned(name)
    held = np.searchsorted(trajectory.times, reference.times + 1e-9)
    same = held[1:] == held[:-1]  # the thrusts do not change between these rows and the next
    axis, v = thrust_axis(reference.attitude), reference.velocity
    acceleration = axis * reference.thrust[:, None] - np.array([0, 0, problem.quadrotor.gravity]) - problem.drag * v
    mean = axis[:-1] * reference.thrust[:-1, None] / 2 + axis[1:] * reference.thrust[:-1, None] / 2
    mean = mean - np.array([0, 0, problem.quadrotor.gravity]) - problem.drag * (v[1:] + v[:-1]) / 2
    assert_allclose(np.diff(v, axis=0)[same], 0.01 * mean[same], atol=2e-3)
    assert_allclose(np.diff(reference.position, axis=0), 0.01 * v[:-1] + 0.5e-4 * acceleration[:-1], atol=1e-3)


def test_it_starts_at_rest_at_the_start_in_the_attitude_of_the_start(name):
    race, _, _, reference = small.planned(name)
    assert_allclose(reference.position[0], race.track.start, atol=1e-6)
    assert_allclose(reference.velocity[0], 0.0, atol=1e-6)
    assert_allclose(reference.attitude[0], race.track.attitude, atol=1e-6)


def test_each_gate_lies_within_the_tolerance_at_its_time(name):
    race, problem, trajectory, reference = small.planned(name)
    ends = trajectory.states[trajectory.ends, :3]
    assert np.linalg.norm(ends - race.track.waypoints, axis=1).max() < problem.tolerance + 1e-4
    distances = np.linalg.norm(reference.position_at(reference.gate_times) - race.track.gate_positions, axis=1)
    assert distances.max() < problem.tolerance + 0.15  # a row is up to 10 ms away


def test_gate_times_ascend_and_the_duration_is_that_of_the_end(name):
    race, _, _, reference = small.planned(name)
    assert len(reference.gate_times) == len(race.track.gates)
    assert np.all(np.diff(reference.gate_times, prepend=0.0) > 0)
    assert (reference.lap_time == pytest.approx(reference.duration)) == (race.track.end is None)


def test_thrusts_and_rates_keep_their_limits(name):
    _, problem, trajectory, reference = small.planned(name)
    low, high = problem.quadrotor.rotor_thrust
    assert low <= reference.rotor_thrusts.min() < reference.rotor_thrusts.max() <= high
    assert np.all(np.abs(trajectory.states[:, 10:]).max(axis=0) <= np.array(problem.quadrotor.rate_limit) + 1e-6)


def test_collective_thrust_per_mass_is_that_of_the_rotors(name):
    _, problem, _, reference = small.planned(name)
    assert_allclose(reference.thrust * problem.quadrotor.mass, reference.rotor_thrusts.sum(axis=1), rtol=1e-12)


def test_limits_grow_with_the_ramp(name):
    _, problem, trajectory, _ = small.planned(name)
    thrust, rates = ramped_limits(problem, trajectory)
    assert np.all(trajectory.controls <= thrust[:, None] * (1 + 1e-3) + 1e-6)
    assert np.all(np.abs(trajectory.states[:, 10:12]) <= rates * (1 + 1e-3) + 1e-6)
    if problem.ramp is not None:
        assert thrust[0] * 4 == pytest.approx(1.5 * problem.quadrotor.mass * problem.quadrotor.gravity)
        assert rates[0] == pytest.approx([4.5, 4.5])
        assert np.all(np.diff(thrust) > 0)


def test_nodes_stay_above_the_floor(name):
    _, problem, trajectory, _ = small.planned(name)
    assert trajectory.states[:, 2].min() >= problem.floor - 1e-6
    if name == "floor":
        assert trajectory.states[:, 2].min() == pytest.approx(problem.floor, abs=1e-3)


def test_attitudes_are_unit_quaternions_without_sign_jumps(name):
    *_, reference = small.planned(name)
    assert_allclose(np.linalg.norm(reference.attitude, axis=1), 1.0, atol=1e-6)
    assert np.einsum("ij,ij->i", reference.attitude[1:], reference.attitude[:-1]).min() > 0.9


def test_rows_end_within_a_period_of_the_duration(name):
    *_, reference = small.planned(name)
    assert reference.planned_rows == len(reference.position)
    assert 0 <= reference.duration - reference.times[-1] < reference.period
