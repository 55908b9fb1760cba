"""The controller with any model: its stages do what dense matrices do, and it flies in the same kernel."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flight import stages
from flight.scenarios import TUNED, fly, make_scenario
from hotlap.dynamics.linearisation import pattern_of
from hotlap.dynamics.models import drag_node_map
from hotlap.flight.controller import Controller
from hotlap.flight.generic_mpc import GeneralBackward, general_backward_stage, general_forward_stage
from hotlap.flight.program import run
from hotlap.flight.riccati import GAIN_SIZE, P_SIZE, triangle
from hotlap.race.controllers import ControllerKind
from hotlap.reference.scenario import Scenario

WEIGHTS, R = np.array([33.5, 357.0, 44.0, 7.1]), np.array([1.0, 1.2, 1.5, 0.7])
PATTERNS = {"dense": {}, "drag": pattern_of(drag_node_map())}
DRAGGED = {"drag": (0.5, 0.5, 0.3), "body_drag": (0.02, 0.02, 0.05)}


def jacobian(pattern: dict, rng: np.random.Generator) -> np.ndarray:
    """Any [A B] that agrees with a pattern."""
    matrix = np.hstack([np.eye(9) + 0.2 * rng.normal(size=(9, 9)), 0.3 * rng.normal(size=(9, 4))])
    for place, value in pattern.items():
        matrix[place] = value
    return matrix


def draw(pattern: dict, seed: int) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    x, u, root = stages.draw_state(rng), np.array([12.0, 0, 0, 0]) + rng.normal(size=4), rng.normal(size=(9, 9))
    return {
        "P": root @ root.T + np.diag(stages.diagonal(WEIGHTS)), "p": 10 * rng.normal(size=9), "C": jacobian(pattern, rng), "x": x, "u": u,
        "deviation": 0.1 * rng.normal(size=9), "change": 0.1 * rng.normal(size=9),
        "reference": np.concatenate([stages.moved(x, 0.2 * rng.normal(size=9)), u + rng.normal(size=4)]),
    }  # fmt: skip


@pytest.mark.parametrize("name", PATTERNS)
@pytest.mark.parametrize("room", [0.5, 1e6], ids=["tight", "wide"])
def test_a_stage_is_riccatis_within_bounds(name, room):
    program, exact = general_backward_stage(PATTERNS[name]), 0
    for seed in range(20):
        s = draw(PATTERNS[name], seed)
        low, high = s["u"] - room, s["u"] + 0.8 * room
        P, p, K, k = np.zeros(P_SIZE), np.zeros(9), np.zeros(GAIN_SIZE), np.zeros(4)
        packed = np.array([s["P"][i, j] for i in range(9) for j in range(i + 1)])
        given = [packed, s["p"], s["C"].ravel(), s["x"], s["deviation"], s["u"], s["reference"], WEIGHTS, R, np.array([0.1]), low, high]
        run(program, [*given, P, p, K, k, np.zeros(GeneralBackward.scratch_size)])
        Q = stages.diagonal(WEIGHTS)
        q = Q * (s["deviation"] - stages.difference(s["x"], s["reference"][:10]))
        r = R * (s["u"] - s["reference"][10:])
        expected = stages.backward(s["P"], s["p"], s["C"][:, :9], s["C"][:, 9:], np.diag(Q), q, np.diag(R), r, low - s["u"], high - s["u"])
        found = (k, K.reshape(4, 9), np.array([[P[triangle(i, j)] for j in range(9)] for i in range(9)]), p)
        exact += all(np.allclose(a, b, rtol=1e-8, atol=1e-8 * np.abs(b).max()) for a, b in zip(found, expected, strict=True))
    assert exact >= (20 if room > 1 else 16)


@pytest.mark.parametrize("name", PATTERNS)
def test_forward_follows_the_linear_model(name):
    s, gains = draw(PATTERNS[name], 3), 0.1 * np.random.default_rng(0).normal(size=(4, 9))
    u, following, deviation, convergence = s["u"].copy(), np.zeros(9), np.zeros(9), np.zeros(2)
    wide, feed = np.full(4, 1e3), np.array([0.1, 0.2, -0.1, 0.0])
    given = [s["C"].ravel(), gains.ravel(), feed, s["change"], u, deviation, np.array([0.1]), -wide, wide, np.ones(1), convergence]
    run(general_forward_stage(PATTERNS[name]), [*given, u, following, deviation, convergence])
    moved = feed + gains @ s["change"]
    assert_allclose(u, s["u"] + moved, rtol=1e-12)
    assert_allclose(following, s["C"] @ [*s["change"], *moved], rtol=1e-9)


def test_a_known_pattern_saves_work():
    assert general_backward_stage(PATTERNS["drag"]).count() < 0.85 * general_backward_stage(PATTERNS["dense"]).count()


def with_kind(kind: ControllerKind, vehicle: dict) -> Scenario:
    scenario = make_scenario(vehicle, model=vehicle)
    return Scenario(scenario.race.with_controller(kind), scenario.reference, scenario.segments)


def commands(kind: ControllerKind, vehicle: dict) -> np.ndarray:
    scenario = with_kind(kind, vehicle)
    controller = Controller(scenario, np.array(TUNED))
    return np.array([controller.command(k * 0.01, scenario.reference.table[k, :10] + 0.02) for k in range(20)])


@pytest.mark.check
def test_without_drag_it_is_the_papers_controller():
    free = {"drag": (0.0, 0.0, 0.0), "rotor_drag": 0.0, "body_drag": (0.0, 0.0, 0.0)}
    assert_allclose(commands(ControllerKind.MPC_DRAG, free), commands(ControllerKind.MPC, free), atol=0.02)


@pytest.mark.check
def test_with_drag_it_pushes_against_it():
    """At speed along x, a model that knows the drag asks for more thrust or tilt than one that does not."""
    apart = np.abs(commands(ControllerKind.MPC_DRAG, DRAGGED) - commands(ControllerKind.MPC, DRAGGED)).max(axis=0)
    assert apart[0] > 0.05 or apart[2] > 0.05


@pytest.mark.check
def test_knowing_the_drag_brings_it_nearer_to_the_reference():
    errors = {}
    for kind in (ControllerKind.MPC, ControllerKind.MPC_DRAG):
        flights = fly(with_kind(kind, DRAGGED), np.tile(TUNED, (8, 2, 1)))
        errors[kind] = flights.mean_error.mean()
    assert errors[ControllerKind.MPC_DRAG] < 0.9 * errors[ControllerKind.MPC]
