"""Worlds drawn around a vehicle: each seed has its own, within the spread, and the vehicle itself is in the middle."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.files import load_quadrotor
from hotlap.truth import DRAGS, MASSES, TRUTH, UNCERTAIN, draw_truths, scale, truth_of

RACER = load_quadrotor("hummingbird").model_copy(update={"delay": 0.045})
TRUE = truth_of(RACER)
SEEDS = np.arange(500)


def column(truths: np.ndarray, name: str) -> np.ndarray:
    return truths[:, TRUTH.index(name)]


def test_the_vehicle_has_a_number_for_every_column():
    assert len(TRUE) == len(TRUTH)
    assert TRUE[TRUTH.index("mass")] == RACER.mass
    assert TRUE[TRUTH.index("delay")] == RACER.delay
    assert {name for names in UNCERTAIN.values() for name in names} <= set(TRUTH)


def test_without_spread_every_world_is_the_vehicle():
    assert_allclose(draw_truths(RACER, SEEDS[:5], 0.0), np.tile(TRUE, (5, 1)))
    assert draw_truths(RACER, SEEDS[:0], 0.1).shape == (0, len(TRUTH))


def test_a_world_is_its_seeds_whatever_is_drawn_beside_it():
    truths = draw_truths(RACER, SEEDS, 0.2)
    assert_array_equal(draw_truths(RACER, SEEDS[[7, 3]], 0.2), truths[[7, 3]])
    assert len(np.unique(truths, axis=0)) == len(SEEDS)


@pytest.mark.parametrize("spread", [0.1, 0.3])
def test_what_is_uncertain_is_spread_evenly_and_nothing_else_moves(spread):
    truths = draw_truths(RACER, SEEDS, spread)
    lag, delay = column(truths, "motor_time_up") / RACER.motor_time[0], column(truths, "delay") / RACER.delay
    for factor in (lag, delay):
        assert factor.min() >= 1 - spread
        assert factor.max() <= 1 + spread
        assert_allclose([factor.mean(), factor.std()], [1, spread / 3**0.5], atol=0.1 * spread)
    still = [TRUTH.index(name) for name in ("arm", "torque_ratio", "rotor_thrust_max", "gravity", "rate_gain_x")]
    assert_array_equal(truths[:, still], np.tile(TRUE[still], (len(SEEDS), 1)))
    assert abs(np.corrcoef(lag, delay)[0, 1]) < 0.1, "each has a factor of its own"


def test_a_stronger_thrust_is_a_lighter_vehicle_with_less_drag_at_every_command():
    truths = draw_truths(RACER, SEEDS, 0.2)
    inertia, mass = column(truths, "inertia_x") / RACER.inertia[0], column(truths, "mass") / RACER.mass
    assert_allclose(inertia, mass)
    assert mass.min() >= 0.8 / 1.2
    assert mass.max() <= 1.2 / 0.8
    assert mass.std() > 0.2 / 3**0.5, "mass and thrust both move it"


def test_scaling_leaves_the_rest_alone():
    doubled = scale(TRUE, MASSES, 2.0)
    assert_allclose(doubled[:4], 2 * TRUE[:4])
    assert_array_equal(doubled[4:], TRUE[4:])
    rows = scale(np.tile(TRUE, (2, 1)), DRAGS, np.array([1.0, 3.0]))
    assert_allclose(rows[1, TRUTH.index("rotor_drag")], 3 * TRUE[TRUTH.index("rotor_drag")])
    assert_array_equal(rows[0], TRUE)
