"""A controller that searches along a line follows its reference with every number of nodes, sweep, period and horizon that is accepted."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from hotlap.files.descriptions import load_race
from hotlap.flight.fly import fly_batch
from hotlap.flight.numbers import best_numbers
from hotlap.planning.preparation import prepare as plan
from hotlap.race.controller_kind import Solver
from hotlap.race.controllers import ControllerKind
from hotlap.race.race import LONGEST_PERIOD, WIDEST_SPACING, ControllerSettings
from hotlap.reference.scenario import Scenario

from . import scenarios
from .perfect_plant import Lane, mean_error

pytestmark = pytest.mark.check  # a kernel of its own is compiled

LEAST, INDIFFERENT = 0.03, 0.04  # m; the second where a position weighs a thousandth of a velocity
WEIGHTS = {"default": (200.0, 500.0, 50.0, 10.0), "tuned": (33.5, 357.0, 44.0, 7.1)}
CORNERS = {"low": (1.0, 100.0, 1.0, 1.0), "high": (1000.0, 1500.0, 100.0, 1000.0), "speed": (1.0, 100.0, 1.0, 1000.0)}
KINDS = [ControllerKind.MPC, pytest.param(ControllerKind.MPC_DRAG, marks=pytest.mark.check)]


def settings(kind: ControllerKind, nodes: int, horizon: float, **others: Any) -> dict[str, Any]:
    """Of a controller whose horizon may be tuned up to a length [s]; those that are refused raise an error."""
    bounds = {
        "low": (1.0, 100.0, 1.0, 1.0, 0.1),
        "high": (1000.0, 1500.0, 100.0, 1000.0, 2 * horizon),
        "default": (9.0, 100.0, 9.0, 9.0, 0.2),
    }
    asked = {"kind": kind, "nodes": nodes, "solver": Solver.LINE_SEARCH, **bounds, **others}
    ControllerSettings(**asked)
    return {**asked, "offset_free": False, "reference_drag": False}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("nodes", "sweeps", "period", "horizon"),
    [
        (2, 1, 0.01, 0.4),
        (7, 2, 0.05, 1.4),
        (18, 1, 0.0025, 3.5),
        (20, 1, 0.05, 3.5),
        (60, 10, 0.01, 3.5),
        (100, 2, 0.01, 0.5),
        (100, 1, 0.05, 3.5),
    ],
)
def test_a_plant_equal_to_the_model_is_followed(kind, nodes, sweeps, period, horizon):
    scenario = scenarios.make_scenario(controller=settings(kind, nodes, horizon, sweeps=sweeps, period=period))
    assert mean_error(scenario, np.array([*WEIGHTS["default"], 2 * horizon])) < LEAST


def drag_free(name: str) -> Scenario:
    """A built-in race planned for a vehicle that is its controller's model: no drag, dead time, lag."""
    race = load_race(name)
    free = {"drag": (0.0, 0.0, 0.0), "rotor_drag": 0.0, "body_drag": (0.0, 0.0, 0.0)}
    vehicle = race.vehicle.model_copy(update={**free, "delay": 0.0})
    quadrotor = race.planning.quadrotor
    planning = {"v_max": None, "quadrotor": quadrotor.model_copy(update=free) if quadrotor else None}
    changes = {"vehicle": vehicle, "model": vehicle, "planning": race.planning.model_copy(update=planning)}
    return plan(race.model_copy(update=changes))


@pytest.mark.parametrize("race", ["circle-34", "split-s"])
@pytest.mark.parametrize("nodes", [2, 5, 18, 20, 40, 100])
def test_fast_references_are_followed_with_every_setting(race, nodes):
    scenario, found = drag_free(race), {}
    for label, weights in {**WEIGHTS, **CORNERS}.items():
        for period in (0.0025, 0.01, LONGEST_PERIOD):
            for horizon in {min(WIDEST_SPACING * nodes, 3.5), min(WIDEST_SPACING * nodes, 0.5)}:
                changes = settings(ControllerKind.MPC, nodes, horizon, sweeps=1, period=period) | {"predict": False}
                controller = scenario.race.controller.model_copy(update=changes)
                flown = Scenario(scenario.race.model_copy(update={"controller": controller}), scenario.reference, scenario.segments)
                found[label, period, horizon] = mean_error(flown, np.array([*weights, 2 * horizon]))
    far = {case: error for case, error in found.items() if error > (INDIFFERENT if case[0] == "speed" else LEAST)}
    assert not far


def away(scenario: Scenario, far: float = 1.0) -> np.ndarray:
    """A state at the start, so many times 2.7 m beside it."""
    state = scenario.reference.table[0, :10].copy()
    state[:3] += np.array([1.5, -2.0, 1.0]) * far
    return state


def test_no_sweep_makes_a_plan_worse():
    costs = []
    for sweeps in range(1, 7):
        scenario = scenarios.make_scenario(controller=settings(ControllerKind.MPC, 20, 3.5, sweeps=sweeps))
        lane = Lane(scenario, np.array(scenarios.TUNED))
        lane.command(0, away(scenario))
        costs.append(lane.memory.cost[0, 0])
    assert costs == sorted(costs, reverse=True)
    assert costs[-1] < 0.99 * costs[0]


def test_commands_keep_their_bounds():
    scenario = scenarios.make_scenario(controller=settings(ControllerKind.MPC, 20, 3.5))
    lane = Lane(scenario, np.array(scenarios.TUNED))
    commands = np.array([lane.command(tick, away(scenario, 10.0)) for tick in range(20)])
    assert (commands >= lane.job.low - 1e-9).all()
    assert (commands <= lane.job.high + 1e-9).all()
    assert (commands < lane.job.low + 0.06).any()


def test_a_flight_does_not_depend_on_the_flights_beside_it():
    scenario = scenarios.make_scenario(controller=settings(ControllerKind.MPC, 10, 1.5), noise={"position": 0.1, "rates": 0.5})
    asked = scenarios.parameters(5) * np.linspace(0.5, 1.0, 5)[:, None, None]
    together = fly_batch(scenario, asked, np.arange(5), numbers=best_numbers(), threads=1)[0]
    for i in range(5):
        alone = fly_batch(scenario, asked[i : i + 1], np.array([i]), numbers=best_numbers(), threads=1)[0]
        assert_array_equal(alone.mean_error, together.mean_error[i : i + 1])
        assert_array_equal(alone.end_position, together.end_position[i : i + 1])
