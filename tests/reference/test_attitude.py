"""Quaternions that follow a thrust axis do so by the shortest way."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from hotlap.reference.attitude import continuous, follow_axes, product, thrust_axis, turn_rates

LEVEL = np.array([1.0, 0.0, 0.0, 0.0])


def draw(count: int, size: int) -> np.ndarray:
    vectors = np.random.default_rng(8).normal(size=(count, size))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def rotation(attitudes: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(attitudes, -1, axis=-1))


def test_products_and_axes_agree_with_scipy():
    a, b = draw(20, 4), draw(20, 4)[::-1]
    assert_allclose(rotation(product(a, b)).as_matrix(), (rotation(a) * rotation(b)).as_matrix(), atol=1e-12)
    assert_allclose(thrust_axis(a), rotation(a).apply([0, 0, 1]), atol=1e-12)


def test_the_axis_is_followed_exactly_and_without_turning_about_it():
    axes = draw(30, 3)
    attitudes = follow_axes(axes, LEVEL)
    assert_allclose(thrust_axis(attitudes), axes, atol=1e-9)
    turns = rotation(attitudes[:-1]).inv() * rotation(attitudes[1:])
    assert_allclose(turns.as_rotvec()[:, 2], 0.0, atol=1e-7)  # in the body frame


def test_the_opposite_axis_is_reached_as_well():
    assert_allclose(thrust_axis(follow_axes(np.array([[0.0, 0.0, -1.0]]), LEVEL)), [[0, 0, -1]], atol=1e-9)


def test_no_turn_exceeds_the_largest_and_the_axis_is_caught_up_with():
    attitudes = np.vstack([LEVEL, follow_axes(np.tile([0.0, 0.0, -1.0], (70, 1)), LEVEL, largest_turn=0.05)])
    angles = (rotation(attitudes[:-1]).inv() * rotation(attitudes[1:])).magnitude()
    assert angles.max() == pytest.approx(0.05)
    assert_allclose(thrust_axis(attitudes[-1]), [0, 0, -1], atol=1e-9)


def test_turn_rates_lead_from_each_attitude_to_the_next():
    attitudes = draw(20, 4)
    rates = turn_rates(attitudes, np.full(19, 0.2))
    reached = rotation(attitudes[:-1]) * Rotation.from_rotvec(0.2 * rates)
    assert_allclose(reached.as_matrix(), rotation(attitudes[1:]).as_matrix(), atol=1e-9)
    assert_allclose(turn_rates(np.tile(LEVEL, (2, 1)), 0.01), 0.0)


def test_continuous_attitudes_are_the_same_rotations_without_sign_jumps():
    attitudes = follow_axes(draw(20, 3), LEVEL)
    jumping = attitudes * np.random.default_rng(1).choice([-1.0, 1.0], size=(20, 1))
    smooth = continuous(jumping)
    assert_allclose(rotation(smooth).as_matrix(), rotation(attitudes).as_matrix(), atol=1e-12)
    assert np.einsum("ij,ij->i", smooth[1:], smooth[:-1]).min() >= 0
