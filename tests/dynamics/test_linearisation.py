"""Any model is linearised as finite differences say, and what is said to be constant is."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

from flight import stages
from hotlap.dynamics import linearisation, models
from hotlap.dynamics.parameter_layout import MODEL

NODES = {"node_map": models.node_map(), "drag_node_map": models.drag_node_map()}
MODELS = pytest.mark.parametrize("name", NODES)
H, STEP = 0.12, 1e-6
DRAGS = np.array([9.81, 0.8, 0.3, 0.2, 0.1, 0.02, 0.01, 0.02, 0.05])  # in the order of MODEL
NO_DRAG = np.array([9.81, 0.8, *np.zeros(7)])


def constants(name: str) -> np.ndarray:
    return DRAGS if name == "drag_node_map" else DRAGS[:1]


def draw(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return stages.draw_state(rng), np.array([12.0, 0, 0, 0]) + rng.normal(size=4) * [3, 2, 2, 1]


def after(name: str, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    return np.array(NODES[name](x, u, H, constants(name))).ravel()


def jacobian(name: str, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    out = linearisation.linearised(NODES[name])(x, u, x, np.zeros(9), H, [-1e3] * 4, [1e3] * 4, constants(name))
    return np.array(out[2]).reshape(9, 13)


@MODELS
@pytest.mark.parametrize("seed", range(5))
def test_the_jacobian_is_that_of_finite_differences(name, seed):
    x, u = draw(seed)
    found, changes = jacobian(name, x, u), STEP * np.eye(13)
    for column, change in zip(found.T, changes, strict=True):
        there, back = (after(name, stages.moved(x, sign * change[:9]), u + sign * change[9:]) for sign in (1, -1))
        assert_allclose(column, stages.difference(back, there) / (2 * STEP), atol=1e-6)


@MODELS
def test_what_is_constant_is_so_everywhere_and_nothing_else(name):
    pattern = linearisation.pattern_of(NODES[name])
    samples = np.array([jacobian(name, *draw(seed)) for seed in range(6)])
    still = {(i, j) for i, j in zip(*np.nonzero(np.ptp(samples, axis=0) == 0), strict=True)}
    assert {(int(i), int(j)) for i, j in still} >= set(pattern)
    for place, value in pattern.items():
        assert (samples[:, *place] == value).all()
    assert pattern[0, 0] == 1.0
    assert ((8, 8) in pattern) == (name == "node_map"), "a drag acts on velocity"
    assert sum(value == 0.0 for value in pattern.values()) >= 36, "a third of it is zero"


def test_without_drag_it_agrees_with_the_linearisation_in_closed_form():
    x, u = draw(3)
    structured = models.linearised_node_map()(x, u, x, np.zeros(9), H, [-1e3] * 4, [1e3] * 4, 9.81)
    A, B = stages.unpack(np.array(structured[2]).ravel(), H)
    found = jacobian("node_map", x, u)
    assert_allclose(found[3:], np.hstack([A, B])[3:], atol=1e-5)
    assert_allclose(found[:3], np.hstack([A, B])[:3], atol=H**3 * 12), "an approximation of third order"


@pytest.mark.parametrize("name", NODES)
def test_the_defect_is_the_way_from_the_plan_to_the_model(name):
    x, u = draw(4)
    following, deviation = stages.moved(after(name, x, u), np.full(9, 0.01)), np.full(9, 1e-4)
    low, high = u - [1, 1, 1, 1], u + [1, 1, -0.5, 1]
    bounded, reached, _ = linearisation.linearised(NODES[name])(x, u, following, deviation, H, low, high, constants(name))
    inside = np.clip(u, low, high)
    assert_allclose(np.array(bounded).ravel(), inside)
    expected = stages.difference(following, after(name, x, u)) + jacobian(name, x, u) @ [*deviation, *(inside - u)]
    assert_allclose(np.array(reached).ravel(), expected, atol=1e-12)


def test_a_vehicle_without_drag_moves_as_the_paper_says():
    x, u = draw(5)
    assert_allclose(np.array(NODES["drag_node_map"](x, u, H, NO_DRAG)).ravel(), after("node_map", x, u), atol=1e-12)


def test_drag_is_integrated_to_second_order():
    """Halving the node quarters the error against many small nodes."""
    x, u = draw(6)

    def fly(steps: int) -> np.ndarray:
        state = x
        for _ in range(steps):
            state = np.array(NODES["drag_node_map"](state, u, H / steps, DRAGS)).ravel()
        return state

    exact = fly(512)
    errors = [np.abs(fly(steps) - exact).max() for steps in (2, 4, 8)]
    assert_allclose([errors[0] / errors[1], errors[1] / errors[2]], 4, rtol=0.25)


def test_the_layout_is_that_of_the_model():
    assert sum(MODEL.values()) == len(DRAGS) == NODES["drag_node_map"].size1_in(3)
    assert isinstance(NODES["node_map"], ca.Function)
