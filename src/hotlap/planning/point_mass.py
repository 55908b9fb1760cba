"""The point-mass plan: thrust as a vector in a ball, from straight lines; where the full plan starts."""

from __future__ import annotations

import dataclasses

import numpy as np

from hotlap.planning.ipopt import Limits, Solution, solve
from hotlap.planning.problem import LONGEST, SHORTEST, Problem, Trajectory
from hotlap.planning.shooting import Shooting
from hotlap.planning.stage import point_mass_in_air_stage, point_mass_stage
from hotlap.planning.warm_start import straight_lines

INTERVALS = 10  # of a phase
THRUST_SHARE = 0.99  # of the quadrotor's, so that it can turn as well
BARRIER, ITERATIONS = 0.1, 200


def plan_point_mass(problem: Problem) -> Solution:
    """The fastest way for a point mass: states (position, velocity), controls thrust per mass (world)."""
    problem = dataclasses.replace(problem, intervals=INTERVALS)
    quadrotor = problem.quadrotor
    durations, positions, velocities = straight_lines(problem)
    hover = np.tile([0.0, 0.0, quadrotor.gravity], (len(positions) - 1, 1))
    guess = Trajectory(durations, np.hstack([positions, velocities]), hover)
    stage = point_mass_in_air_stage() if problem.full else point_mass_stage()
    shooting = Shooting(stage, problem.phases, INTERVALS, thrust_ball=True)
    model = np.array([quadrotor.gravity, problem.drag, *([problem.quadratic_drag] if problem.full else [])])
    return solve(shooting, problem.waypoints, model, guess, _limits(problem, guess), barrier=BARRIER, iterations=ITERATIONS)


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
