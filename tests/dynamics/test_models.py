"""The equations of motion obey physics, and the controller's node agrees with a fine integration of them."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from hotlap.dynamics import models
from hotlap.dynamics.parameter_layout import AIRFRAME
from hotlap.race.rotors import RotorLayout, torque_matrix

GRAVITY = 9.81
MASS, INERTIA, TORQUES = 0.85, np.array([0.004, 0.006, 0.009]), torque_matrix(RotorLayout.X, 0.2, 0.03)
PLANNING, POINT_MASS = models.planning_model(), models.point_mass()
AIRFRAME_MODEL, POINT_MASS_IN_AIR = models.airframe(), models.point_mass_in_air()
NODE, LINEARISED = models.node_map(), models.linearised_node_map()
ANGLES = (0.0, 0.3, 1.0, 2.0)  # rad that a node may turn by
SERIES = 1.5e-6  # error of the truncated series over the eighth power of the angle


def call(function: ca.Function, *arguments: Any) -> np.ndarray:
    return np.array(function(*arguments)).ravel()


def rotation(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1))


def draw(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def unit(rng: np.random.Generator, size: int) -> np.ndarray:
    vector = rng.normal(size=size)
    return vector / np.linalg.norm(vector)


def numeric(build: Any, *sizes: int) -> ca.Function:
    """A function of vectors, as something to call."""
    symbols = [ca.SX.sym("s", size) for size in sizes]
    return ca.Function("made", symbols, [build(*symbols)])


PRODUCT, MATRIX = numeric(models.quaternion_product, 4, 4), numeric(models.rotation_matrix, 4)
TANGENT, JACOBIAN = numeric(models.tangent, 4, 4), numeric(models.node_jacobian, 10, 4, 1)


def model(drag: float = 0.0) -> np.ndarray:
    return np.concatenate([[MASS, GRAVITY, drag], INERTIA, TORQUES.ravel()])


def test_products_and_matrices_agree_with_scipy():
    rng = draw(0)
    for _ in range(10):
        a, b = unit(rng, 4), unit(rng, 4)
        assert_allclose(rotation(call(PRODUCT, a, b)).as_matrix(), (rotation(a) * rotation(b)).as_matrix(), atol=1e-12)
        assert_allclose(np.array(MATRIX(a)), rotation(a).as_matrix(), atol=1e-12)
        assert_allclose(call(numeric(models.thrust_axis, 4), a), rotation(a).as_matrix()[:, 2], atol=1e-12)


def test_a_tangent_is_twice_the_vector_part_of_the_turn():
    q = unit(draw(1), 4)
    turn = np.array([0.02, -0.01, 0.03])
    turned = call(PRODUCT, q, np.roll(Rotation.from_rotvec(turn).as_quat(), 1))
    assert_allclose(call(TANGENT, q, turned), turn, rtol=1e-3)


def test_planned_motion_conserves_what_it_must():
    """Power is thrust . velocity; without torque neither |J w| nor |q| changes."""
    rng = draw(2)
    for _ in range(10):
        p, v, q, w = rng.normal(size=3), 5 * rng.normal(size=3), unit(rng, 4), 3 * rng.normal(size=3)
        state = np.concatenate([p, v, q, w])
        thrusts = rng.uniform(1, 4, 4)
        rate = call(PLANNING, state, thrusts, model())
        power = MASS * v @ rate[3:6] + MASS * GRAVITY * rate[2]
        assert_allclose(power, thrusts.sum() * rotation(q).apply([0, 0, 1]) @ v, rtol=1e-12)
        assert_allclose(q @ rate[6:10], 0.0, atol=1e-12)
        free = call(PLANNING, state, np.full(4, 2.0), model())
        assert_allclose((INERTIA * w) @ (INERTIA * free[10:]), 0.0, atol=1e-12)


def test_without_thrust_it_falls():
    state = np.concatenate([np.zeros(6), unit(draw(3), 4), np.zeros(3)])
    assert_allclose(call(PLANNING, state, np.zeros(4), model())[3:6], [0, 0, -GRAVITY], atol=1e-15)


def test_drag_slows_and_torques_turn_by_their_own_axis():
    velocity = np.array([3.0, -2.0, 1.0])
    state = np.concatenate([np.zeros(3), velocity, [1, 0, 0, 0], np.zeros(3)])
    thrusts = np.array([1.0, 2.0, 3.0, 5.0])
    with_drag, without = (call(PLANNING, state, thrusts, model(drag)) for drag in (0.4, 0.0))
    assert_allclose(with_drag[3:6] - without[3:6], -0.4 * velocity, atol=1e-14)
    assert_allclose(without[10:], TORQUES @ thrusts / INERTIA, rtol=1e-14)


def test_the_point_mass_is_the_quadrotor_without_attitude():
    rng = draw(4)
    p, v, q, thrusts = rng.normal(size=3), rng.normal(size=3), unit(rng, 4), rng.uniform(1, 4, 4)
    whole = call(PLANNING, np.concatenate([p, v, q, np.zeros(3)]), thrusts, model(0.3))
    push = rotation(q).apply([0, 0, thrusts.sum() / MASS])
    assert_allclose(call(POINT_MASS, np.concatenate([p, v]), push, [GRAVITY, 0.3]), whole[:6], rtol=1e-12)


def vehicle(**drags: Any) -> np.ndarray:
    """Values of `AIRFRAME`."""
    values = {"mass": MASS, "gravity": GRAVITY, "inertia": INERTIA, "torques": TORQUES, "drag": np.zeros(3), "rotor_drag": 0.0}
    values = {**values, "body_drag": np.zeros(3), **drags}
    return np.concatenate([np.ravel(values[name]) for name in AIRFRAME])


ALL_DRAGS = {"drag": (0.3, 0.3, 0.1), "rotor_drag": 0.03, "body_drag": (0.02, 0.02, 0.1)}


def test_the_airframe_without_drags_is_the_planning_model_without_drag():
    rng = draw(7)
    state = np.concatenate([rng.normal(size=6), unit(rng, 4), rng.normal(size=3)])
    thrusts = rng.uniform(1, 4, 4)
    assert_allclose(call(AIRFRAME_MODEL, state, thrusts, vehicle()), call(PLANNING, state, thrusts, model()), rtol=1e-12)


def test_the_airframe_drags_as_the_plant_does():
    rng = draw(8)
    v, q, thrusts = 5 * rng.normal(size=3), unit(rng, 4), rng.uniform(1, 4, 4)
    air = rotation(q).inv().apply(v)
    force = -np.array(ALL_DRAGS["body_drag"]) * air * np.abs(air) - MASS * np.array(ALL_DRAGS["drag"]) * air
    force[:2] -= ALL_DRAGS["rotor_drag"] * np.sqrt(thrusts).sum() * air[:2]
    state = np.concatenate([np.zeros(3), v, q, np.zeros(3)])
    with_drags, without = (call(AIRFRAME_MODEL, state, thrusts, vehicle(**drags))[3:6] for drags in (ALL_DRAGS, {}))
    assert_allclose(with_drags - without, rotation(q).apply(force) / MASS, rtol=1e-5)


def test_the_point_mass_in_air_is_the_airframe_along_its_thrust():
    rng = draw(9)
    p, v, q = rng.normal(size=3), 10 * np.array([1.0, 0.0, 0.5]), np.array([np.cos(0.3), 0.0, np.sin(0.3), 0.0])  # flies in its own plane
    whole = call(AIRFRAME_MODEL, np.concatenate([p, v, q, np.zeros(3)]), np.full(4, 3.0), vehicle(**ALL_DRAGS))
    push = rotation(q).apply([0, 0, 12.0 / MASS])
    assert_allclose(call(POINT_MASS_IN_AIR, np.concatenate([p, v]), push, vehicle(**ALL_DRAGS)), whole[:6], rtol=2e-3)


def flow(x: np.ndarray, u: np.ndarray, h: float) -> np.ndarray:
    """A node by fine integration."""

    def rate(_: float, x: np.ndarray) -> np.ndarray:
        w, vector = x[3], x[4:7]
        turn = 0.5 * np.concatenate([[-vector @ u[1:]], w * u[1:] + np.cross(vector, u[1:])])
        return np.concatenate([x[7:], turn, rotation(x[3:7]).apply([0, 0, u[0]]) - [0, 0, GRAVITY]])

    return solve_ivp(rate, (0, h), x, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]


def draw_node(angle: float, h: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = draw(seed)
    x = np.concatenate([rng.normal(size=3), unit(rng, 4), 8 * rng.normal(size=3)])
    return x, np.concatenate([[15.0], angle / h * unit(rng, 3)])


@pytest.mark.parametrize("angle", ANGLES)
def test_a_node_is_integrated_exactly(angle):
    for seed in range(5):
        x, u = draw_node(angle, 0.175, seed)  # the longest that a horizon of 7 has
        assert_allclose(call(NODE, x, u, 0.175, GRAVITY), flow(x, u, 0.175), atol=1e-10 + SERIES * angle**8)


@pytest.mark.parametrize("angle", ANGLES)
def test_rotations_in_series_are_those_in_closed_form(angle):
    phi = angle * unit(draw(5), 3)
    turn = Rotation.from_rotvec(phi)
    assert_allclose(
        call(numeric(models.rotation_quaternion, 3), phi), np.roll(turn.as_quat(canonical=True), 1), atol=1e-9 + SERIES * angle**8
    )
    vector = np.array([0.3, -0.5, 1.0])
    share, weights = np.polynomial.legendre.leggauss(12)
    share, weights = (share + 1) / 2, weights / 2
    turned = np.array([Rotation.from_rotvec(s * phi).apply(vector) for s in share])
    once = numeric(lambda phi, vector: models.rotation_integral(phi, vector, 1), 3, 3)
    twice = numeric(lambda phi, vector: models.rotation_integral(phi, vector, 2), 3, 3)
    assert_allclose(call(once, phi, vector), weights @ turned, atol=1e-9 + SERIES * angle**8)
    assert_allclose(call(twice, phi, vector), (weights * (1 - share)) @ turned, atol=1e-9 + SERIES * angle**8)


@pytest.mark.parametrize("angle", ANGLES)
def test_the_right_jacobian_turns_a_small_change_of_the_vector_into_one_of_the_attitude(angle):
    phi, step = angle * unit(draw(6), 3), 1e-5
    jacobian = np.array(numeric(models.right_jacobian, 3)(phi))
    for k, direction in enumerate(np.eye(3)):
        around = [Rotation.from_rotvec(phi + sign * step * direction) for sign in (-1, 1)]
        change = (around[0].inv() * around[1]).as_rotvec() / (2 * step)
        assert_allclose(jacobian[:, k], change, atol=1e-9 + SERIES * angle**8)


def retract(x: np.ndarray, change: np.ndarray) -> np.ndarray:
    """x moved by (p, theta, v), attitudes as q o [1, theta / 2]."""
    turn = np.concatenate([[1.0], change[3:6] / 2])
    q = call(PRODUCT, x[3:7], turn / np.linalg.norm(turn))
    return np.concatenate([x[:3] + change[:3], q, x[7:] + change[6:]])


def difference(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """From a to b, in the same coordinates."""
    return np.concatenate([b[:3] - a[:3], call(TANGENT, a[3:7], b[3:7]), b[7:] - a[7:]])


def dense_jacobian(x: np.ndarray, u: np.ndarray, h: float) -> np.ndarray:
    """[A B] of a node as `node_jacobian` describes it, shape (9, 13)."""
    packed = call(JACOBIAN, x, u, h)
    turn, rates, speed = packed[:9].reshape(3, 3), packed[9:18].reshape(3, 3), packed[18:].reshape(3, 7)
    full = np.zeros((9, 13))
    full[:3, :3] = full[6:, 6:9] = np.eye(3)
    full[3:6, 3:6], full[3:6, 10:] = turn, rates
    full[6:, 3:6], full[6:, 9:] = speed[:, :3], speed[:, 3:]
    full[:3] += h / 2 * full[6:]
    full[:3, 6:9] += h / 2 * np.eye(3)
    return full


def measured_jacobian(x: np.ndarray, u: np.ndarray, h: float) -> np.ndarray:
    """The same by central differences."""
    step, columns = 1e-6, []
    for direction in np.eye(13):
        ends = [call(NODE, retract(x, s * direction[:9]), u + s * direction[9:], h, GRAVITY) for s in (-step, step)]
        middle = call(NODE, x, u, h, GRAVITY)
        columns.append((difference(middle, ends[1]) - difference(middle, ends[0])) / (2 * step))
    return np.stack(columns, axis=1)


@pytest.mark.parametrize("angle", ANGLES)
def test_a_node_is_linearised_in_tangent_coordinates(angle):
    x, u = draw_node(angle, 0.15, 7)
    assert_allclose(dense_jacobian(x, u, 0.15)[3:], measured_jacobian(x, u, 0.15)[3:], atol=1e-6 + SERIES * angle**8)


def test_positions_are_linearised_to_third_order():
    """Halving the node divides the error of the positions' rows by eight."""
    x, u = draw_node(0.4, 0.1, 8)
    errors = [np.abs((dense_jacobian(x, u, h) - measured_jacobian(x, u, h))[:3, 3:6]).max() for h in (0.1, 0.05, 0.025)]
    assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 3.0, atol=0.2)


def test_linearised_nodes_bound_the_input_and_carry_the_deviation():
    h, rng = 0.1, draw(9)
    x, u = draw_node(0.5, h, 9)
    u[0] = 25.0
    low, high = np.array([0.1, -10, -10, -3]), np.array([20.0, 10, 10, 3])
    following, deviation = retract(call(NODE, x, u, h, GRAVITY), 0.01 * rng.normal(size=9)), 1e-4 * rng.normal(size=9)
    bounded, reached, packed = (np.array(part).ravel() for part in LINEARISED(x, u, following, deviation, h, low, high, GRAVITY))
    assert_allclose(bounded, np.clip(u, low, high))
    assert_allclose(packed, call(JACOBIAN, x, u, h), rtol=1e-12)
    change = dense_jacobian(x, u, h) @ np.concatenate([deviation, bounded - u])
    assert_allclose(reached, difference(following, call(NODE, x, u, h, GRAVITY)) + change, atol=1e-12)
