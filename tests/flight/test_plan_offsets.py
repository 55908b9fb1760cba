"""What acts along the horizon of a line search is what acts in its own plan."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from hotlap.race.controller_kind import ControllerKind, Solver
from hotlap.reference.scenario import Scenario

from . import scenarios
from .perfect_plant import Lane

BESIDE = np.array([1.5, -2.0, 1.0])  # m, from the reference: the plan is faster than that
DRAG = (0.6, 0.4, 0.2)
SPACING = 0.1


def scenario_of(**controller: bool) -> Scenario:
    """The small race whose model has drag, flown by a line search that knows it."""
    settings = {"solver": Solver.LINE_SEARCH, "offset_free": False, "reference_drag": True, **controller}
    return scenarios.make_scenario(model={"drag": DRAG}, controller=settings)


def second_step(scenario: Scenario, kind: ControllerKind = ControllerKind.MPC) -> tuple[Lane, np.ndarray, np.ndarray]:
    """A controller after two steps in a state beside the reference; that state, and the offsets of the plan after the first, moved on."""
    scenario = Scenario(scenario.race.with_controller(kind), scenario.reference, scenario.segments)
    lane, state = Lane(scenario, np.array([*scenarios.TUNED[:4], 4.0])), scenario.reference.table[120, :10].copy()
    state[:3] += BESIDE
    lane.command(120, state)
    before = lane.memory.X[:, :, 0].copy()
    places = np.minimum(np.arange(len(before)) + lane.settings.period / SPACING, len(before) - 1)
    moved = np.array([np.interp(places, np.arange(len(before)), column) for column in before.T]).T
    lane.command(121, state)
    return lane, state, moved


def drag_of(states: np.ndarray) -> np.ndarray:
    """Deceleration by linear drag in states p q v, shape (n, 3) (world)."""
    turns = Rotation.from_quat(np.roll(states[:, 3:7], -1, axis=1))
    return turns.apply(np.array(DRAG) * turns.apply(states[:, 7:10], inverse=True))


@pytest.mark.check
def test_drag_along_the_horizon_is_that_of_the_last_plan():
    lane, state, moved = second_step(scenario_of())
    planned = moved + lane.memory.reference[:, :10, 0]
    planned[0] = state
    along = drag_of(lane.memory.reference[:, :10, 0])
    assert np.abs(along - drag_of(planned)).max() > 1.0
    assert np.abs(moved[:, 7:10]).max() > 1.0, "a plan that is not the reference"
    assert_allclose(lane.memory.push[:, :, 0], -drag_of(planned), atol=0.04)


@pytest.mark.check
def test_a_target_makes_up_for_the_drag_of_the_last_plan():
    """Its body z is that of the thrust of the reference without drag, less what acts."""
    lane, *_ = second_step(scenario_of())
    times = 1.21 + SPACING * np.arange(len(lane.memory.reference))
    rows = lane.job.table[np.rint(times * 100).astype(int)]
    z, now = (Rotation.from_quat(np.roll(q, -1, axis=1)).apply([0, 0, 1]) for q in (rows[:, 3:7], lane.memory.reference[:, 3:7, 0]))
    wanted = rows[:, 10:11] * z - lane.memory.push[:, :, 0]
    assert_allclose(now, wanted / np.linalg.norm(wanted, axis=1, keepdims=True), atol=1e-3)
    assert lane.memory.reference[-1, 10, 0] == pytest.approx(np.linalg.norm(wanted[-1]), abs=1e-3)


@pytest.mark.check
def test_a_model_with_drag_is_pushed_by_the_disturbance_alone():
    lane, *_ = second_step(scenario_of(), ControllerKind.MPC_DRAG)
    assert_allclose(lane.memory.push, 0.0, atol=1e-12)
