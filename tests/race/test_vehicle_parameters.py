"""Vehicles drawn around a vehicle: each seed has its own, within the spread, and the vehicle itself is in the middle."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.files.descriptions import load_quadrotor
from hotlap.race.vehicle_parameters import (
    DRAGS,
    MASSES,
    UNCERTAIN,
    VEHICLE_PARAMETERS,
    draw_vehicle_parameters,
    scale,
    vehicle_parameters_of,
)

RACER = load_quadrotor("hummingbird").model_copy(update={"delay": 0.045})
TRUE = vehicle_parameters_of(RACER)
SEEDS = np.arange(500)


def column(rows: np.ndarray, name: str) -> np.ndarray:
    return rows[:, VEHICLE_PARAMETERS.index(name)]


def test_the_vehicle_has_a_number_for_every_column():
    assert len(TRUE) == len(VEHICLE_PARAMETERS)
    assert TRUE[VEHICLE_PARAMETERS.index("mass")] == RACER.mass
    assert TRUE[VEHICLE_PARAMETERS.index("delay")] == RACER.delay
    assert {name for names in UNCERTAIN.values() for name in names} <= set(VEHICLE_PARAMETERS)


def test_without_spread_every_world_is_the_vehicle():
    assert_allclose(draw_vehicle_parameters(RACER, SEEDS[:5], 0.0), np.tile(TRUE, (5, 1)))
    assert draw_vehicle_parameters(RACER, SEEDS[:0], 0.1).shape == (0, len(VEHICLE_PARAMETERS))


def test_a_world_is_its_seeds_whatever_is_drawn_beside_it():
    rows = draw_vehicle_parameters(RACER, SEEDS, 0.2)
    assert_array_equal(draw_vehicle_parameters(RACER, SEEDS[[7, 3]], 0.2), rows[[7, 3]])
    assert len(np.unique(rows, axis=0)) == len(SEEDS)


@pytest.mark.parametrize("spread", [0.1, 0.3])
def test_what_is_uncertain_is_spread_evenly_and_nothing_else_moves(spread):
    rows = draw_vehicle_parameters(RACER, SEEDS, spread)
    lag, delay = column(rows, "motor_time_up") / RACER.motor_time[0], column(rows, "delay") / RACER.delay
    for factor in (lag, delay):
        assert factor.min() >= 1 - spread
        assert factor.max() <= 1 + spread
        assert_allclose([factor.mean(), factor.std()], [1, spread / 3**0.5], atol=0.1 * spread)
    still = [VEHICLE_PARAMETERS.index(name) for name in ("arm", "torque_ratio", "rotor_thrust_max", "gravity", "rate_gain_x")]
    assert_array_equal(rows[:, still], np.tile(TRUE[still], (len(SEEDS), 1)))
    assert abs(np.corrcoef(lag, delay)[0, 1]) < 0.1, "each has a factor of its own"


def test_a_stronger_thrust_is_a_lighter_vehicle_with_less_drag_at_every_command():
    rows = draw_vehicle_parameters(RACER, SEEDS, 0.2)
    inertia, mass = column(rows, "inertia_x") / RACER.inertia[0], column(rows, "mass") / RACER.mass
    assert_allclose(inertia, mass)
    assert mass.min() >= 0.8 / 1.2
    assert mass.max() <= 1.2 / 0.8
    assert mass.std() > 0.2 / 3**0.5, "mass and thrust both move it"


def test_scaling_leaves_the_rest_alone():
    doubled = scale(TRUE, MASSES, 2.0)
    assert_allclose(doubled[:4], 2 * TRUE[:4])
    assert_array_equal(doubled[4:], TRUE[4:])
    rows = scale(np.tile(TRUE, (2, 1)), DRAGS, np.array([1.0, 3.0]))
    assert_allclose(rows[1, VEHICLE_PARAMETERS.index("rotor_drag")], 3 * TRUE[VEHICLE_PARAMETERS.index("rotor_drag")])
    assert_array_equal(rows[0], TRUE)
