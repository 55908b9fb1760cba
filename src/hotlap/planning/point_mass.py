"""The point-mass plan: thrust as a vector in a ball, from straight lines; where the full plan starts."""

from __future__ import annotations

import dataclasses

import numpy as np

from hotlap.planning.full_stage import airframe_parameters
from hotlap.planning.ipopt import Limits, Solution, solve
from hotlap.planning.problem import LONGEST, SHORTEST, Problem, Trajectory
from hotlap.planning.shooting import Shooting
from hotlap.planning.stage import point_mass_in_air_stage, point_mass_stage
from hotlap.planning.warm_start import straight_lines

INTERVALS = 10  # of a phase
THRUST_SHARE = 0.99  # of the quadrotor's, so that it can turn as well
UPRIGHT, TILTED = (0.0, 0.0, 1.0), (0.3, 0.2, 1.0)  # first thrusts, in units of the weight
BARRIER, ITERATIONS = 0.1, 200


def plan_point_mass(problem: Problem) -> Solution:
    """The fastest way for a point mass: states (position, velocity), controls thrust per mass (world).

    A thrust that begins upright never leaves the vertical on a vertical track, where the best may lie upside down: a search that does
    not end is repeated from a thrust that is tilted.
    """
    solution = _plan(problem, UPRIGHT, ITERATIONS)
    return solution if solution.converged else _plan(problem, TILTED, 2 * ITERATIONS)


def _plan(problem: Problem, thrust: tuple[float, float, float], iterations: int) -> Solution:
    """The plan from straight lines with a constant thrust, in units of the weight (world)."""
    problem = dataclasses.replace(problem, intervals=INTERVALS)
    quadrotor = problem.quadrotor
    durations, positions, velocities = straight_lines(problem)
    thrusts = np.tile(quadrotor.gravity * np.array(thrust), (len(positions) - 1, 1))
    guess = Trajectory(durations, np.hstack([positions, velocities]), thrusts)
    stage = point_mass_in_air_stage() if problem.full else point_mass_stage()
    shooting = Shooting(stage, problem.phases, INTERVALS, thrust_ball=True)
    model = airframe_parameters(quadrotor) if problem.full else np.array([quadrotor.gravity, problem.drag])
    return solve(shooting, problem.waypoints, model, guess, _limits(problem, guess), barrier=BARRIER, iterations=iterations)


def _limits(problem: Problem, guess: Trajectory) -> Limits:
    """Rest at the start, above the floor, thrust within the ball."""
    low, high = np.full(guess.states.shape, -np.inf), np.full(guess.states.shape, np.inf)
    low[:, 2] = problem.floor
    low[0] = high[0] = guess.states[0]
    thrust = problem.quadrotor.max_acceleration
    box, ones = np.full(guess.controls.shape, thrust), np.ones(problem.phases)
    return Limits(
        low=Trajectory(SHORTEST * ones, low, -box),
        high=Trajectory(LONGEST * ones, high, box),
        tolerance=problem.tolerance,
        thrust=THRUST_SHARE * thrust,
    )
