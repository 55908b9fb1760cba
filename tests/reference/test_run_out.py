"""The run-out goes on smoothly and slows down."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from hotlap.reference.attitude import thrust_axis
from hotlap.reference.reference import Reference
from hotlap.reference.run_out import BLEND, LARGEST_RATE, RUN_OUT, SLOWING, extend
from planning import small

GRAVITY = np.array([0.0, 0.0, 9.801])


def extended(name: str) -> tuple[Reference, int, float]:
    """A small plan with its run-out, the row that it begins at, and the drag of its model."""
    _, problem, _, reference = small.planned(name)
    return extend(reference, problem.quadrotor.gravity, problem.drag), reference.planned_rows, problem.drag


def ending(attitude: tuple[float, float, float, float], thrust: float, velocity: tuple[float, float, float]) -> Reference:
    """A reference of which only the last row matters."""
    *_, reference = small.planned("drag")
    last = {"attitude": attitude, "thrust": thrust, "velocity": velocity}
    changed = {}
    for name, value in last.items():
        changed[name] = getattr(reference, name).copy()
        changed[name][-1] = value
    return dataclasses.replace(reference, **changed)


def turns(attitudes: np.ndarray) -> np.ndarray:
    """Body rates that lead from each row to the next, from scipy, shape (rows - 1, 3)."""
    rotations = Rotation.from_quat(np.roll(attitudes, -1, axis=1))
    return (rotations[:-1].inv() * rotations[1:]).as_rotvec() / 0.01


each = pytest.mark.parametrize("name", list(small.RACES))


@pytest.mark.check
@each
def test_it_lasts_nine_seconds_and_leaves_the_plan_as_it_is(name):
    reference, rows, _ = extended(name)
    planned = small.planned(name)[3]
    assert len(reference.position) == rows + 900 == rows + RUN_OUT * 100
    for field in ("position", "attitude", "velocity", "rates", "thrust", "rotor_thrusts"):
        assert_array_equal(getattr(reference, field)[:rows], getattr(planned, field))
    assert (reference.planned_rows, reference.duration) == (rows, planned.duration)


@each
def test_position_velocity_and_acceleration_go_on_without_a_jump(name):
    reference, rows, drag = extended(name)
    position, velocity = reference.position[rows - 2 :], reference.velocity[rows - 2 :]
    middle = (velocity[1:] + velocity[:-1]) / 2
    assert_allclose(np.diff(position, axis=0), 0.01 * middle, atol=1e-3)
    last = reference.thrust[rows - 1] * thrust_axis(reference.attitude[rows - 1]) - GRAVITY - drag * reference.velocity[rows - 1]
    accelerations = np.diff(reference.velocity[rows - 1 :], axis=0) / 0.01
    assert_allclose(accelerations[0], last, atol=0.1)
    assert np.abs(np.diff(accelerations, axis=0)).max() < 1.5 * 30 / BLEND * 0.01


@each
def test_after_the_blend_the_speed_decays(name):
    reference, rows, _ = extended(name)
    velocity = reference.velocity[rows + round(BLEND * 100) :]
    assert_allclose(velocity, velocity[0] * np.exp(-np.arange(len(velocity)) * 0.01 / SLOWING)[:, None], atol=1e-3)


@each
def test_attitude_turns_no_faster_than_allowed_and_rates_are_its_own(name):
    reference, rows, _ = extended(name)
    found = turns(reference.attitude[rows - 1 :])
    assert np.linalg.norm(found, axis=1).max() <= LARGEST_RATE + 1e-6
    assert_allclose(reference.rates[rows:-1], (found[:-1] + found[1:]) / 2, atol=1e-6)
    assert np.linalg.norm(reference.rates[rows:], axis=1).max() <= LARGEST_RATE + 1e-6


@each
def test_thrust_is_what_the_acceleration_needs_and_soon_points_there(name):
    reference, rows, _ = extended(name)
    velocity = reference.velocity[rows:]
    needed = np.gradient(velocity, 0.01, axis=0) + GRAVITY
    assert_allclose(reference.thrust[rows + 1 : -1], np.linalg.norm(needed, axis=1)[1:-1], atol=0.2)
    axes = needed / np.linalg.norm(needed, axis=1, keepdims=True)
    assert_allclose(thrust_axis(reference.attitude[rows + 100 : -1]), axes[100:-1], atol=0.01)


@each
def test_rotor_thrusts_are_unknown_there_and_nothing_else_is(name):
    reference, rows, _ = extended(name)
    assert np.isnan(reference.rotor_thrusts[rows:]).all()
    assert np.isfinite(reference.table).all()
    assert_allclose(np.linalg.norm(reference.attitude, axis=1), 1.0, atol=1e-6)


@each
def test_a_run_out_replaces_an_older_one(name):
    reference, _, drag = extended(name)
    again = extend(reference, small.planned(name)[1].quadrotor.gravity, drag)
    assert_array_equal(again.table, reference.table)


def test_an_attitude_far_from_what_is_needed_is_left_smoothly():
    reference = ending((0.0, 1.0, 0.0, 0.0), 1.0, (3.0, 0.0, 0.0))  # upside down, and thrust must point up
    found = turns(extend(reference, 9.801, 0.0).attitude[reference.planned_rows - 1 :])
    assert np.linalg.norm(found, axis=1).max() == pytest.approx(LARGEST_RATE)


def test_in_free_fall_the_attitude_stays():
    reference = extend(ending((1.0, 0.0, 0.0, 0.0), 0.0, (0.0, 0.0, 0.0)), 9.801, 0.0)
    rows = reference.planned_rows
    assert np.isfinite(reference.table[rows:]).all()
    assert_allclose(thrust_axis(reference.attitude[rows:]), np.tile([0.0, 0.0, 1.0], (900, 1)), atol=1e-6)
