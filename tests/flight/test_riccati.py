"""The stages of the controller's solver do what dense matrices do."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.dynamics.models import node_jacobian
from hotlap.flight.program import Program, run
from hotlap.flight.riccati import (
    GAIN_SIZE,
    P_SIZE,
    SCRATCH_SIZE,
    backward_stage,
    forward_stage,
    invert,
    terminal_stage,
    triangle,
)

from . import stages

BACKWARD, FORWARD, TERMINAL = backward_stage(), forward_stage(), terminal_stage()
WEIGHTS, R, H = np.array([33.5, 357.0, 44.0, 7.1]), np.array([1.0, 1.2, 1.5, 0.7]), 0.15
TIGHT, WIDE = 0.5, 1e6


def full(packed: np.ndarray) -> np.ndarray:
    return np.array([[packed[triangle(i, j)] for j in range(9)] for i in range(9)])


def pack(matrix: np.ndarray) -> np.ndarray:
    return np.array([matrix[i, j] for i in range(9) for j in range(i + 1)])


def jacobian(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    import casadi as ca  # noqa: PLC0415

    a, b = ca.SX.sym("x", 10), ca.SX.sym("u", 4)
    return np.array(ca.Function("j", [a, b], [node_jacobian(a, b, H)])(x, u)).ravel()


def stage(seed: int, room: float) -> dict[str, Any]:
    """A stage whose bounds leave so much room around its input."""
    rng = np.random.default_rng(seed)
    x, u = stages.draw_state(rng), np.array([12.0, 0, 0, 0]) + rng.normal(size=4)
    root = rng.normal(size=(9, 9))
    reference = np.concatenate([stages.moved(x, 0.2 * rng.normal(size=9)), u + rng.normal(size=4)])
    low, high = u - room * rng.uniform(0.1, 1, 4), u + room * rng.uniform(0.1, 1, 4)
    return {
        "P": 20 * root @ root.T / 9 + np.diag(stages.diagonal(WEIGHTS)), "p": 10 * rng.normal(size=9), "C": jacobian(x, u), "x": x,
        "deviation": 0.1 * rng.normal(size=9), "u": u, "reference": reference, "low": low, "high": high,
    }  # fmt: skip


def solve(s: dict[str, Any]) -> stages.Policy:
    """The stage by its program."""
    P, p, K, k = np.zeros(P_SIZE), np.zeros(9), np.zeros(GAIN_SIZE), np.zeros(4)
    inputs = [pack(s["P"]), s["p"], s["C"], s["x"], s["deviation"], s["u"], s["reference"], WEIGHTS, R, np.array([H]), s["low"], s["high"]]
    run(BACKWARD, [*inputs, P, p, K, k, np.zeros(SCRATCH_SIZE)])
    return stages.Policy(k, K.reshape(4, 9), full(P), p)


def expect(s: dict[str, Any]) -> stages.Policy:
    """The stage in dense matrices."""
    A, B = stages.unpack(s["C"], H)
    Q = stages.diagonal(WEIGHTS)
    slope = Q * (s["deviation"] - stages.difference(s["x"], s["reference"][:10]))
    r = R * (s["u"] - s["reference"][10:])
    return stages.backward(s["P"], s["p"], A, B, np.diag(Q), slope, np.diag(R), r, s["low"] - s["u"], s["high"] - s["u"])


def agree(found: stages.Policy, expected: stages.Policy) -> None:
    for mine, theirs in zip(found, expected, strict=True):
        assert_allclose(mine, theirs, rtol=1e-8, atol=1e-8 * np.abs(theirs).max())


@pytest.mark.parametrize("seed", range(8))
def test_without_bounds_a_stage_is_riccatis(seed):
    s = stage(seed, WIDE)
    agree(solve(s), expect(s))


def test_within_bounds_stages_are_the_best_that_they_allow():
    """Two projected Newton steps find the set of active bounds, but for rare cases, where they come close."""
    exact = 0
    for seed in range(40):
        s = stage(seed, TIGHT)
        found, expected = solve(s), expect(s)
        assert (found.step >= s["low"] - s["u"] - 1e-12).all()
        assert (found.step <= s["high"] - s["u"] + 1e-12).all()
        assert_allclose(found.step, expected.step, atol=0.05)
        if np.allclose(found.step, expected.step, rtol=1e-9, atol=1e-9):
            exact += 1
            agree(found, expected)
    assert exact >= 36


def test_some_of_these_stages_have_bounds_that_hold():
    held = [(expect(stage(seed, TIGHT)).gains == 0).all(axis=1).sum() for seed in range(30)]
    assert min(held) < 2
    assert max(held) == 4
    assert len(set(held)) >= 4


def test_held_inputs_have_no_feedback():
    s = stage(0, 1e-9)
    found = solve(s)
    assert_array_equal(found.gains, np.zeros((4, 9)))
    A = stages.unpack(s["C"], H)[0]
    assert_allclose(found.P, np.diag(stages.diagonal(WEIGHTS)) + A.T @ s["P"] @ A, rtol=1e-9, atol=1e-6)


def test_the_last_node_is_charged_its_error():
    s = stage(3, WIDE)
    P, p = np.zeros(P_SIZE), np.zeros(9)
    run(TERMINAL, [s["x"], s["deviation"], s["reference"], WEIGHTS, P, p])
    Q = stages.diagonal(WEIGHTS)
    assert_array_equal(full(P), np.diag(Q))
    assert_allclose(p, Q * (s["deviation"] - stages.difference(s["x"], s["reference"][:10])), rtol=1e-12)


def test_an_attitude_error_costs_its_quaternion():
    """Q |q - q_ref|^2 = Q / 4 |theta|^2 for small angles."""
    x = np.concatenate([np.zeros(3), [1.0, 0, 0, 0], np.zeros(3)])
    theta = np.array([0.01, -0.02, 0.005])
    turned = stages.moved(x, np.concatenate([np.zeros(3), theta, np.zeros(3)]))
    assert_allclose(np.sum((turned[3:7] - x[3:7]) ** 2), np.sum(theta**2) / 4, rtol=1e-3)
    assert_allclose(stages.diagonal(WEIGHTS)[3:6], WEIGHTS[2] / 4)


def walk(
    s: dict[str, Any], policy: stages.Policy, change: np.ndarray, *, needs_sweep: bool, convergence: Any = (0.0, 0.0)
) -> tuple[Any, ...]:
    """The forward program: inputs, change of the next deviation, next deviation, convergence."""
    u, following, deviation, convergence = s["u"].copy(), np.zeros(9), np.full(9, 0.3), np.array(convergence)
    inputs = [
        s["C"],
        policy.gains.ravel(),
        policy.step,
        change,
        u,
        deviation,
        np.array([H]),
        s["low"],
        s["high"],
        np.array([float(needs_sweep)]),
    ]
    run(FORWARD, [*inputs, convergence, u, following, deviation, convergence])
    return u, following, deviation, convergence


def test_forward_follows_the_policy_and_the_linear_model():
    s, change = stage(5, WIDE), 0.1 * np.random.default_rng(5).normal(size=9)
    policy = expect(s)
    u, following, deviation, convergence = walk(s, policy, change, needs_sweep=True)
    A, B = stages.unpack(s["C"], H)
    assert_allclose(u - s["u"], policy.step + policy.gains @ change, rtol=1e-9)
    assert_allclose(following, A @ change + B @ (u - s["u"]), rtol=1e-9)
    assert_allclose(deviation, 0.3 + following, rtol=1e-12)
    assert_allclose(convergence, [np.abs(u - s["u"]).max(), 0.0])


def test_forward_keeps_the_bounds_and_says_so():
    s, change = stage(6, TIGHT), 2.0 * np.random.default_rng(6).normal(size=9)
    policy = expect(s)._replace(gains=np.full((4, 9), 0.2))
    u, following, _, convergence = walk(s, policy, change, needs_sweep=True)
    assert_allclose(u, np.clip(s["u"] + policy.step + policy.gains @ change, s["low"], s["high"]))
    assert_allclose(convergence, [np.abs(u - s["u"]).max(), 1.0])
    A, B = stages.unpack(s["C"], H)
    assert_allclose(following, A @ change + B @ (u - s["u"]), rtol=1e-9)


def test_unrest_is_that_of_all_nodes_so_far():
    s = stage(5, WIDE)
    assert_array_equal(walk(s, expect(s), np.zeros(9), needs_sweep=True, convergence=(50.0, 1.0))[3], [50.0, 1.0])


def test_a_lane_that_is_done_changes_no_bit():
    s = stage(7, TIGHT)
    u, following, deviation, convergence = walk(s, expect(s), np.zeros(9), needs_sweep=False)
    assert_array_equal(u, s["u"])
    assert_array_equal(following, np.zeros(9))
    assert_array_equal(deviation, np.full(9, 0.3))
    assert convergence[0] == 0.0


@pytest.mark.parametrize("seed", range(5))
def test_four_by_four_matrices_are_inverted(seed):
    root = np.random.default_rng(seed).normal(size=(4, 4))
    matrix = root @ root.T + 0.1 * np.eye(4)
    inverse = invert({(i, j): matrix[i, j] for i in range(4) for j in range(i + 1)})
    assert_allclose([[inverse[max(i, j), min(i, j)] for j in range(4)] for i in range(4)], np.linalg.inv(matrix), rtol=1e-9, atol=1e-12)


def test_a_triangle_has_every_place_once():
    assert sorted(triangle(i, j) for i in range(9) for j in range(i + 1)) == list(range(P_SIZE))
    assert all(triangle(i, j) == triangle(j, i) for i in range(9) for j in range(9))


def test_the_backward_stage_stays_small():
    """Its cost is the cost of a flight; more operations must be a decision."""
    assert isinstance(BACKWARD, Program)
    assert BACKWARD.count() < 2500
