"""The controller's plan is the solution of the quadratic problem around the plan that it began from."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.flight import mpc as controller

from . import stages
from .controls import HIGH, LOW, ControlLoop, Mpc, best_plan, control_step, draw_problem, settings

NODES = 10
PROBLEMS = range(24)


def solve(problem: tuple[Mpc, ControlLoop], sweeps: int) -> tuple[np.ndarray, np.ndarray]:
    """States and inputs of the plan after a control step."""
    mpc, loop = problem
    control_step(settings(sweeps=sweeps), mpc, loop)
    return mpc.X[..., 0], mpc.U[..., 0]


@pytest.mark.parametrize("nodes", [1, 2, 20])
def test_without_bounds_one_sweep_is_exact(nodes):
    for seed in PROBLEMS:
        problem = draw_problem(seed, nodes, away=0.3)
        problem[0].low[:], problem[0].high[:] = -1e6, 1e6
        states, inputs = best_plan(*problem)
        found = solve(problem, 1)
        assert_allclose(found[1], inputs, atol=1e-9)
        assert_allclose(found[0], states, atol=1e-9)


@pytest.mark.parametrize("away", [0.02, 0.1, 0.3])
def test_within_bounds_sweeps_lead_to_the_exact_solution(away):
    for seed in PROBLEMS:
        problem = draw_problem(seed, NODES, away=away)
        states, inputs = best_plan(*problem)
        found = solve(problem, 10)
        assert_allclose(found[1], inputs, atol=1e-8)
        assert_allclose(found[0], states, atol=1e-8)


def test_many_inputs_of_these_problems_are_at_a_bound():
    inputs = np.array([best_plan(*draw_problem(seed, NODES, away=0.1))[1] for seed in PROBLEMS])
    at_bound = np.isclose(inputs, LOW) | np.isclose(inputs, HIGH)
    assert 0.15 < at_bound.mean() < 0.3
    assert at_bound.any(axis=(1, 2)).all()


@pytest.mark.parametrize(("away", "exact", "furthest"), [(0.02, 23, 0.01), (0.1, 20, 0.05)])
def test_two_sweeps_are_nearly_always_enough_for_the_first_input(away, exact, furthest):
    errors = []
    for seed in PROBLEMS:
        problem = draw_problem(seed, NODES, away=away)
        best = best_plan(*problem)[1]
        errors.append(np.abs(solve(problem, 2)[1][0] - best[0]).max())
    assert np.sum(np.array(errors) < 1e-8) >= exact
    assert max(errors) < furthest


@pytest.mark.parametrize("sweeps", [1, 2, 10])
def test_inputs_never_leave_their_bounds(sweeps):
    for seed in PROBLEMS:
        _, inputs = solve(draw_problem(seed, NODES, away=2.0), sweeps)
        assert (inputs >= LOW).all()
        assert (inputs <= HIGH).all()


def test_a_solution_stays():
    """Repeated from where it stands, the plan comes to rest, and there it solves its own problem."""
    problem = draw_problem(3, NODES, away=0.1)
    for _ in range(30):
        solve(problem, 2)
    states, inputs = best_plan(*problem)
    assert_allclose(problem[0].U[..., 0], inputs, atol=1e-6)
    assert_allclose(problem[0].X[..., 0], states, atol=1e-6)


def test_the_plan_begins_at_the_state_seen_and_obeys_the_model_where_it_was_linear():
    problem = draw_problem(1, NODES, away=0.0)
    states, inputs = solve(problem, 2)
    assert_allclose(states[0], problem[1].seen[:, 0], atol=1e-12)
    assert_allclose(np.linalg.norm(states[:, 3:7], axis=1), 1.0, atol=1e-12)
    assert_array_equal(problem[1].history[0, :, 0], inputs[0])


def test_plans_are_moved_in_tangent_coordinates():
    rng = np.random.default_rng(0)
    x, change, out = stages.draw_state(rng), 0.3 * rng.normal(size=9), np.zeros(10)
    controller.retract(x, change, out)
    assert_allclose(out, stages.moved(x, change), atol=1e-12)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_memory_is_of_one_kind_and_within_cache_lines(kind):
    memory = controller.allocate_mpc(4, 8, kind)
    for array in memory:
        assert array.dtype == kind
        assert array.shape[-1] == 8
        assert array.flags.c_contiguous
        assert array.ctypes.data % 64 == 0
