"""Attitudes, rates and rotor thrusts follow from a motion."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.files.descriptions import load_quadrotor
from hotlap.race.flight_performance import steady_thrust
from hotlap.race.race import PlanDynamics
from hotlap.reference.attitude import rotate, thrust_axis
from hotlap.reference_files.flatness import (
    along_axis,
    attitudes_along,
    attitudes_of_angles,
    attitudes_with_yaw,
    rates_of,
    rotor_thrusts,
    slopes,
)
from hotlap.reference_files.thrust_vectors import axes_of, planned_thrust, with_drag
from planning import small

LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
PERIOD = 0.01
TIMES = PERIOD * np.arange(200)


def wandering(seed: int) -> np.ndarray:
    """Thrust vectors that change smoothly, also to hang upside down."""
    rng = np.random.default_rng(seed)
    phases = rng.uniform(0, 2 * np.pi, size=(3, 1))
    return (np.array([[0.0], [0.0], [6.0]]) + 10 * np.sin(phases + rng.uniform(0.5, 3, size=(3, 1)) * TIMES)).T


@pytest.mark.parametrize("seed", range(5))
def test_the_thrust_axis_points_along_the_thrust_with_any_yaw_or_none(seed):
    vectors = wandering(seed)
    for attitudes in (attitudes_along(vectors, LEVEL), attitudes_with_yaw(vectors, TIMES)):
        assert_allclose(np.linalg.norm(attitudes, axis=1), 1.0)
        assert_allclose(thrust_axis(attitudes), axes_of(vectors), atol=1e-9)
        assert (np.einsum("ij,ij->i", attitudes[1:], attitudes[:-1]) > 0).all()


def test_without_a_yaw_the_drone_never_turns_about_its_own_axis():
    rates = rates_of(attitudes_along(wandering(3), LEVEL), PERIOD)
    assert np.abs(rates[:, 2]).max() < 0.01 * np.abs(rates[:, :2]).max()


def test_left_keeps_its_side_in_a_loop():
    angle = np.linspace(0, 2 * np.pi, 500)
    loop = np.column_stack([np.sin(angle), 0 * angle, np.cos(angle)])
    left = rotate(attitudes_with_yaw(loop, 0 * angle), np.tile([0.0, 1.0, 0.0], (500, 1)))
    assert_allclose(left, np.tile([0.0, 1.0, 0.0], (500, 1)), atol=1e-9)


def test_in_free_fall_the_direction_before_stays():
    vectors = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1e-3], [0.0, 2.0, 0.0]])
    half = np.sqrt(0.5)
    assert_allclose(axes_of(vectors), [[half, 0, half], [half, 0, half], [half, 0, half], [0, 1, 0]])
    assert_allclose(axes_of(np.zeros((2, 3))), [[0, 0, 1], [0, 0, 1]])


def test_a_steady_turn_has_its_rate():
    angles = np.column_stack([0 * TIMES, 0 * TIMES, 1.5 * TIMES])
    assert_allclose(rates_of(attitudes_of_angles(angles), PERIOD), np.tile([0.0, 0.0, 1.5], (len(TIMES), 1)), atol=1e-9)


def test_angles_turn_about_z_then_y_then_x():
    quarter = np.pi / 2
    attitudes = attitudes_of_angles(np.array([[0.0, 0.0, quarter], [0.0, quarter, 0.0], [quarter, 0.0, 0.0], [quarter, 0.0, quarter]]))
    ahead = rotate(attitudes, np.tile([1.0, 0.0, 0.0], (4, 1)))
    assert_allclose(ahead, [[0, 1, 0], [0, 0, -1], [1, 0, 0], [0, 1, 0]], atol=1e-12)
    assert_allclose(thrust_axis(attitudes)[3], [1, 0, 0], atol=1e-12)  # banked to its right, heading along y


def test_slopes_of_parabolas_are_exact():
    values = np.column_stack([TIMES**2, 3 * TIMES])
    first, second = slopes(values, PERIOD, times=2)
    assert_allclose(first, np.column_stack([2 * TIMES, 3 + 0 * TIMES]), atol=1e-9)
    assert_allclose(second, np.tile([2.0, 0.0], (len(TIMES), 1)), atol=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_rotors_give_the_thrust_and_never_pull(seed):
    quadrotor, vectors = load_quadrotor("split-s-racer"), wandering(seed)
    attitudes = attitudes_along(vectors, LEVEL)
    thrust, rates = along_axis(vectors, attitudes), rates_of(attitudes, PERIOD)
    rotors = rotor_thrusts(quadrotor, thrust, rates, PERIOD)
    assert rotors.min() >= -1e-9
    assert_allclose(rotors.sum(axis=1), quadrotor.mass * thrust)


def test_rotors_give_the_torque_of_a_turn_that_grows():
    quadrotor = load_quadrotor("split-s-racer")
    rates = np.outer(TIMES, [2.0, -1.0, 0.3])
    rotors = rotor_thrusts(quadrotor, np.full(len(TIMES), 12.0), rates, PERIOD)
    inertia = quadrotor.inertia_vector
    assert_allclose(rotors @ quadrotor.torque_matrix.T, inertia * [2.0, -1.0, 0.3] + np.cross(rates, inertia * rates), atol=1e-9)


def test_a_plan_with_all_drags_leans_against_that_of_its_largest_speed_too():
    vehicle = load_quadrotor("airsim").model_copy(update={"body_drag": (0.0, 0.0, 0.0)})
    settings = {"quadrotor": None, "v_max": 15.0, "dynamics": PlanDynamics.FULL}
    planning = small.RACES["drag"].planning.model_copy(update=settings)
    race = small.RACES["drag"].model_copy(update={"vehicle": vehicle, "model": None, "planning": planning})
    vector = planned_thrust(race, np.array([[10.0, 0.0, 0.0]]), np.zeros((1, 3)))[0]
    assert race.planning_drag > 0
    assert_allclose(vector, [10 * race.planning_drag, 0, vehicle.gravity], atol=1e-3)


def test_level_flight_takes_the_thrust_that_the_vehicle_needs_there():
    for name in ("hummingbird", "airsim", "split-s-racer"):
        quadrotor = load_quadrotor(name)
        for speed in (5.0, 10.0, 15.0):
            vector = with_drag(quadrotor, np.array([[speed, 0.0, 0.0]]), np.zeros((1, 3)))[0]
            assert_allclose(np.linalg.norm(vector), steady_thrust(quadrotor, speed), rtol=0.005)
