"""The program's sparse derivatives are those of its constraints."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.planning.linear_rows import LinearRows
from hotlap.planning.minimum_time import model_parameters
from hotlap.planning.problem import Problem, Trajectory
from hotlap.planning.shooting import Shooting
from hotlap.planning.stage import point_mass_stage, quadrotor_stage

from . import small

PHASES, INTERVALS = 2, 3
ROWS = LinearRows.joined([
    LinearRows.of(2, np.array([[1.0, 2.0, 0.0], [0.0, -1.0, 3.0]]), -np.inf, 1.0),
    LinearRows.of(5, np.array([0.0, 1.0, 0.0, 0.5, 0.0, -2.0]), 0.1, 0.1),
])  # fmt: skip
PROGRAMS = {
    "phases of their own length, with linear rows": (
        Shooting(point_mass_stage(), PHASES, INTERVALS, thrust_ball=True, counts=(4, 1), linear=ROWS),
        np.array([9.81, 0.3]),
    ),
    "point mass": (Shooting(point_mass_stage(), PHASES, INTERVALS, thrust_ball=True), np.array([9.81, 0.3])),
    "quadrotor": (Shooting(quadrotor_stage(), PHASES, INTERVALS), model_parameters(Problem.of(small.RACES["drag"]))),
}

each_program = pytest.mark.parametrize(("shooting", "model"), PROGRAMS.values(), ids=PROGRAMS)


def draw(shooting: Shooting, model: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Any variables and parameters."""
    rng = np.random.default_rng(2)
    z = rng.uniform(0.5, 1.5, size=shooting.size)
    return z, shooting.parameters(rng.normal(size=(PHASES, 3)), model)


def differentiate(function, z: np.ndarray, step: float = 1e-5) -> np.ndarray:
    return np.stack([(function(z + step * e) - function(z - step * e)) / (2 * step) for e in np.eye(len(z))], axis=-1)


def jacobian(shooting: Shooting, z: np.ndarray, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    constraints, matrix = shooting.derivatives["jac_g"](z, parameters)
    return np.asarray(constraints).ravel(), np.asarray(matrix.full())


@each_program
def test_the_jacobian_agrees_with_finite_differences(shooting, model):
    z, parameters = draw(shooting, model)
    expected = differentiate(lambda z: jacobian(shooting, z, parameters)[0], z)
    assert_allclose(jacobian(shooting, z, parameters)[1], expected, atol=1e-7)


@each_program
def test_the_hessian_agrees_with_finite_differences_of_the_jacobian(shooting, model):
    z, parameters = draw(shooting, model)
    multipliers = np.random.default_rng(5).normal(size=shooting.rows)
    upper = shooting.derivatives["hess_lag"](z, parameters, 0.7, multipliers).full()
    expected = differentiate(lambda z: multipliers @ jacobian(shooting, z, parameters)[1], z)
    assert_allclose(upper, np.triu(expected), atol=1e-6)


@each_program
def test_the_objective_is_the_duration(shooting, model):
    z, parameters = draw(shooting, model)
    value, gradient = shooting.derivatives["grad_f"](z, parameters)
    assert float(value) == pytest.approx(shooting.unpack(z).duration)
    assert_array_equal(np.asarray(gradient).ravel(), np.arange(shooting.size) < PHASES)


@each_program
def test_unpacking_undoes_packing(shooting, model):
    z, _ = draw(shooting, model)
    assert_array_equal(shooting.pack(shooting.unpack(z)), z)


@each_program
def test_constraints_vanish_on_a_flight_through_the_waypoints(shooting, model):
    rng = np.random.default_rng(6)
    states, controls, durations = (
        [np.abs(rng.normal(size=shooting.stage.nx))],
        rng.uniform(1, 2, (shooting.total, shooting.stage.nu)),
        np.array([0.3, 0.6]),
    )
    for control, step in zip(controls, Trajectory(durations, controls, controls, shooting.counts).steps, strict=True):
        states.append(np.asarray(shooting.stage.step(states[-1], control, step, model)).ravel())
    flight = Trajectory(durations, np.array(states), controls, shooting.counts)
    constraints, _ = jacobian(shooting, shooting.pack(flight), shooting.parameters(flight.states[flight.ends, :3], model))
    assert_allclose(constraints[: shooting.gap_rows + PHASES], 0.0, atol=1e-12)
    if shooting.thrust_ball:
        rows = constraints[shooting.gap_rows + PHASES : shooting.nonlinear_rows]
        assert_allclose(rows, (controls**2).sum(axis=1))
    linear = (flight.states[shooting.linear.nodes, :6] * shooting.linear.coefficients).sum(axis=1)
    assert_allclose(constraints[shooting.nonlinear_rows :], linear)
