"""Plans of many laps begin with the plan of three, whose second lap is repeated."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hotlap.planning.laps import FEW, MANY, few_laps, repeat_lap
from hotlap.planning.planner import find_plan
from hotlap.planning.problem import Problem, Trajectory
from hotlap.race.race import PlanDynamics
from hotlap.reference.attitude import product, thrust_axis

from .test_openings import LAST, SQUARE, make_race

LAPS = 8
BACK = {"position": (2.0, 5.0, 1.5), "yaw": 3.9, "side": 1.4}


def problem_of(laps: int, dynamics: PlanDynamics = PlanDynamics.IDEAL) -> Problem:
    quadrotor = {"quadrotor": None} if dynamics is PlanDynamics.FULL else {}
    return Problem.of(make_race(SQUARE, LAST, BACK, laps=laps, closed=True, planning={"nodes": 6, "dynamics": dynamics, **quadrotor}))


@cache
def repeated(dynamics: PlanDynamics) -> tuple[Problem, Trajectory, Trajectory]:
    problem = problem_of(LAPS, dynamics)
    few = few_laps(problem)
    assert few is not None
    plan = find_plan(few)
    return problem, plan, repeat_lap(problem, few, plan)


def test_few_laps_are_planned_as_they_are():
    assert few_laps(problem_of(MANY - 1)) is None


def test_the_short_plan_is_that_of_a_track_with_as_many_laps():
    few, own = few_laps(problem_of(LAPS)), problem_of(FEW)
    assert few is not None
    assert_allclose(few.waypoints, own.waypoints)
    assert few.counts == own.counts
    assert few.targets[-1].waypoint == own.targets[-1].waypoint


@pytest.mark.parametrize("dynamics", [PlanDynamics.IDEAL, pytest.param(PlanDynamics.FULL, marks=pytest.mark.check)])
def test_repeated_laps_have_the_same_ways_and_thrusts(dynamics):
    problem, few, guess = repeated(dynamics)
    assert len(guess.states) == problem.intervals_in_all + 1
    phases = problem.phases // LAPS
    first, last = few.ends[phases - 1], few.ends[2 * phases - 1]
    for lap in range(1, LAPS - 1):
        nodes = slice(guess.ends[lap * phases - 1] + 1, guess.ends[(lap + 1) * phases - 1] + 1)
        own = guess.states[nodes]
        assert_allclose(own[:, :6], few.states[first + 1 : last + 1, :6])
        assert_allclose(thrust_axis(own[:, 6:10]), thrust_axis(few.states[first + 1 : last + 1, 6:10]), atol=1e-9)
    assert_allclose(guess.states[-1, :6], few.states[-1, :6])


@pytest.mark.parametrize("dynamics", [PlanDynamics.IDEAL, pytest.param(PlanDynamics.FULL, marks=pytest.mark.check)])
def test_attitudes_and_rates_go_on_from_lap_to_lap(dynamics):
    problem, few, guess = repeated(dynamics)
    phases = problem.phases // LAPS
    usual = few.ends[phases - 1]
    for lap in range(2, LAPS):
        seam = guess.ends[lap * phases - 1]
        assert_allclose(turned_between(guess, seam), turned_between(few, usual), atol=0.1)


def turned_between(plan: Trajectory, node: int) -> np.ndarray:
    """The turn from a node to the next about the body's axes, less what its rates say [rad]."""
    turn = product(plan.states[node, 6:10] * [1, -1, -1, -1], plan.states[node + 1, 6:10])
    rates = 0.5 * (plan.states[node, 10:13] + plan.states[node + 1, 10:13])
    return 2 * turn[1:] * np.sign(turn[0]) - plan.steps[node] * rates


@pytest.mark.check
def test_a_plan_of_many_laps_is_about_as_long_as_its_guess():
    problem, _, guess = repeated(PlanDynamics.IDEAL)
    assert find_plan(problem).duration == pytest.approx(guess.duration, rel=0.01)
