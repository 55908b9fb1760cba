"""One interval: its derivatives are exact, its integrator accurate."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from hotlap.dynamics.models import planning_model
from hotlap.dynamics.parameter_layout import AIRFRAME
from hotlap.planning.full_stage import full_stage
from hotlap.planning.minimum_time import model_parameters
from hotlap.planning.problem import Problem
from hotlap.planning.stage import Stage, point_mass_in_air_stage, point_mass_stage, quadrotor_stage

from . import small

MODEL = model_parameters(Problem.of(small.RACES["drag"]))
FULL = model_parameters(Problem.of(small.FULL["full"]))
STAGES = [
    pytest.param(point_mass_stage(), np.array([9.81, 0.3]), id="point mass"),
    pytest.param(point_mass_in_air_stage(), FULL[: sum(AIRFRAME.values())], id="point mass in air"),
    pytest.param(quadrotor_stage(), MODEL, id="quadrotor"),
    pytest.param(full_stage(), FULL, id="full"),
]


def draw(stage: Stage) -> np.ndarray:
    """Any w = (state, control, step)."""
    rng = np.random.default_rng(3)
    w = np.concatenate([rng.normal(size=stage.nx), rng.uniform(1.0, 3.0, size=stage.nu), [0.07]])
    if stage.nx >= 13:
        w[6:10] /= np.linalg.norm(w[6:10])
    w[13 : stage.nx] = np.abs(w[13 : stage.nx])  # rotor thrusts
    return w


def split(stage: Stage, w: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    return w[: stage.nx], w[stage.nx : -1], float(w[-1])


def differentiate(function, w: np.ndarray, step: float = 1e-5) -> np.ndarray:
    """Central differences, one column for each part of w."""
    return np.stack([(function(w + step * e) - function(w - step * e)) / (2 * step) for e in np.eye(len(w))], axis=-1)


def dense(sparsity, nonzeros) -> np.ndarray:
    matrix = np.zeros(sparsity.shape)
    matrix[tuple(np.array(sparsity.get_triplet()))] = np.asarray(nonzeros).ravel()
    return matrix


@pytest.mark.parametrize(("stage", "parameters"), STAGES)
def test_the_jacobian_agrees_with_finite_differences(stage, parameters):
    w = draw(stage)
    after, nonzeros = stage.jacobian(*split(stage, w), parameters)
    expected = differentiate(lambda w: np.asarray(stage.step(*split(stage, w), parameters)).ravel(), w)
    assert_allclose(dense(stage.jacobian_sparsity, nonzeros), expected, atol=1e-7)
    assert_allclose(np.asarray(after), np.asarray(stage.step(*split(stage, w), parameters)), rtol=1e-12)


@pytest.mark.parametrize(("stage", "parameters"), STAGES)
def test_the_hessian_agrees_with_finite_differences_of_the_jacobian(stage, parameters):
    w, multipliers = draw(stage), np.random.default_rng(4).normal(size=stage.nx)

    def gradient(w):
        return multipliers @ dense(stage.jacobian_sparsity, stage.jacobian(*split(stage, w), parameters)[1])

    upper = dense(stage.hessian_sparsity, stage.hessian(*split(stage, w), parameters, multipliers))
    assert_allclose(upper, np.triu(differentiate(gradient, w)), atol=1e-6)


def test_the_quadrotors_step_agrees_with_a_tight_integrator():
    stage, model, w = quadrotor_stage(), planning_model(), draw(quadrotor_stage())
    state, control, step = split(stage, w)
    solution = solve_ivp(lambda _, x: np.asarray(model(x, control, MODEL)).ravel(), (0, step), state, rtol=1e-10, atol=1e-12)
    assert_allclose(np.asarray(stage.step(state, control, step, MODEL)).ravel(), solution.y[:, -1], atol=1e-4)


def test_no_thrust_is_gained_by_a_long_quaternion():
    stage = quadrotor_stage()
    state, control, step = split(stage, draw(stage))
    state[6:10] *= 1.3
    after = np.asarray(stage.step(state, control, step, MODEL)).ravel()
    assert np.linalg.norm(after[6:10]) == pytest.approx(1.0)


def test_without_thrust_it_falls_freely():
    stage, parameters = quadrotor_stage(), MODEL.copy()
    parameters[2] = 0.0  # no drag
    state = np.array([0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0], dtype=float)
    after = np.asarray(stage.step(state, np.zeros(4), 0.2, parameters)).ravel()
    assert_allclose(after[:6], [0.2, 0, -0.5 * parameters[1] * 0.04, 1, 0, -0.2 * parameters[1]], atol=1e-12)
