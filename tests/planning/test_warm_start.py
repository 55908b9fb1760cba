"""Warm starts pass the waypoints, from the state of the start."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.planning.point_mass import plan_point_mass
from hotlap.planning.warm_start import around_point_mass, hover_along, straight_lines
from hotlap.reference.attitude import thrust_axis

from . import small


def test_straight_lines_meet_every_waypoint_at_one_speed():
    problem = small.planned("drag")[1]
    durations, positions, velocities = straight_lines(problem)
    assert_allclose(positions[problem.intervals :: problem.intervals], problem.waypoints, atol=1e-12)
    assert_allclose(velocities[0], 0.0)
    speeds = np.linalg.norm(velocities[1:], axis=1)
    assert_allclose(speeds, speeds[0])
    assert_allclose(durations * speeds[0], problem.legs)


def test_hovering_along_them_carries_the_weight():
    problem = small.planned("drag")[1]
    plan = hover_along(problem)
    assert plan.controls.sum(axis=1) == pytest.approx(problem.quadrotor.mass * problem.quadrotor.gravity)
    assert_allclose(plan.states[:, 6:10], np.tile(problem.attitude, (len(plan.states), 1)))


def test_around_a_point_mass_the_thrust_is_that_of_the_point_mass():
    problem = small.planned("drag")[1]
    mass = plan_point_mass(problem).trajectory
    plan = around_point_mass(problem, mass)
    assert_allclose(plan.durations, mass.durations)
    assert_allclose(plan.states[0, 6:10], problem.attitude)
    middles, wanted = 0.5 * (mass.times[1:] + mass.times[:-1]), thrust_axis(plan.states[1:, 6:10])
    thrust = np.stack([np.interp(plan.times[1:], middles, column) for column in mass.controls.T], axis=1)
    assert_allclose(wanted, thrust / np.linalg.norm(thrust, axis=1, keepdims=True), atol=1e-7)


def test_a_point_mass_is_faster_than_a_quadrotor_but_not_much():
    _, problem, trajectory, _ = small.planned("drag")
    ratio = trajectory.duration / plan_point_mass(problem).trajectory.duration
    assert 1.0 < ratio < 1.1
