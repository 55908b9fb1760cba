"""The point-mass plan: thrust as a vector in a ball, from straight lines; where the full plan starts."""

from __future__ import annotations

import dataclasses

import numpy as np

from hotlap.planning.bounds import bound_positions
from hotlap.planning.ipopt import Limits, Solution, solve
from hotlap.planning.linear_rows import LinearRows
from hotlap.planning.problem import LONGEST, Problem, Trajectory
from hotlap.planning.shooting import Shooting
from hotlap.planning.stage import point_mass_stage
from hotlap.planning.warm_start import straight_lines

INTERVALS = 10  # of a phase
THRUST_SHARE = 0.99  # of the quadrotor's, so that it can turn as well
BARRIER, ITERATIONS = 0.1, 200


def plan_point_mass(problem: Problem, guess: Trajectory | None = None, rows: LinearRows | None = None) -> Solution:
    """The fastest way for a point mass: states (position, velocity), controls thrust per mass (world).

    Args:
        problem: what is planned.
        guess: where to begin. None: at straight lines, or curves along the normals of gates.
        rows: what nodes keep to besides the openings.
    """
    problem = coarse(problem)
    guess = guess_point_mass(problem) if guess is None else guess
    shooting = Shooting.of(point_mass_stage(), problem, rows, thrust_ball=True)
    model = np.array([problem.quadrotor.gravity, problem.drag])
    return solve(shooting, problem.waypoints, model, guess, _limits(problem, guess), barrier=BARRIER, iterations=ITERATIONS)


def guess_point_mass(problem: Problem) -> Trajectory:
    """Straight lines or curves, with the thrust of hover."""
    durations, positions, velocities = straight_lines(problem)
    hover = np.tile([0.0, 0.0, problem.quadrotor.gravity], (len(positions) - 1, 1))
    return Trajectory(durations, np.hstack([positions, velocities]), hover, problem.counts)


def coarse(problem: Problem) -> Problem:
    """The problem with the point mass's number of intervals."""
    return dataclasses.replace(problem, intervals=INTERVALS)


def _limits(problem: Problem, guess: Trajectory) -> Limits:
    """From the start, within floor and walls, thrust within the ball."""
    low, high = np.full(guess.states.shape, -np.inf), np.full(guess.states.shape, np.inf)
    bound_positions(problem, guess.intervals, low, high)
    thrust = problem.quadrotor.max_acceleration
    box, ones = np.full(guess.controls.shape, thrust), np.ones(problem.phases)
    return Limits(
        low=Trajectory(problem.shortest, low, -box),
        high=Trajectory(LONGEST * ones, high, box),
        tolerance=problem.radii,
        thrust=THRUST_SHARE * thrust,
    )
