"""The point-mass plan: thrust as a vector in a ball, from straight lines; where the full plan starts."""

from __future__ import annotations

import dataclasses

import numpy as np

from hotlap.planning.bounds import bound_positions
from hotlap.planning.ipopt import Limits, Solution, solve
from hotlap.planning.linear_rows import LinearRows
from hotlap.planning.problem import LONGEST, Problem, Trajectory
from hotlap.planning.shooting import Shooting
from hotlap.planning.stage import point_mass_in_air_stage, point_mass_stage
from hotlap.planning.warm_start import straight_lines
from hotlap.race.airframe import airframe_parameters

INTERVALS = 10  # of a phase
THRUST_SHARE = 0.99  # of the quadrotor's, so that it can turn as well
UPRIGHT, TILTED = (0.0, 0.0, 1.0), (0.3, 0.2, 1.0)  # first thrusts, in units of the weight
BARRIER, ITERATIONS = 0.1, 200


def plan_point_mass(problem: Problem, guess: Trajectory | None = None, rows: LinearRows | None = None) -> Solution:
    """The fastest way for a point mass: states (position, velocity), controls thrust per mass (world).

    A thrust that begins upright never leaves the vertical on a vertical track, where the best may lie upside down: a search that does
    not end is repeated from a thrust that is tilted.

    Args:
        problem: what is planned.
        guess: where to begin. None: at straight lines, or curves along the normals of gates, with the thrust of hover.
        rows: what nodes keep to besides the openings.
    """
    problem = coarse(problem)
    solution = _plan(problem, guess_point_mass(problem) if guess is None else guess, rows, ITERATIONS)
    return solution if solution.converged else _plan(problem, guess_point_mass(problem, TILTED), rows, 2 * ITERATIONS)


def _plan(problem: Problem, guess: Trajectory, rows: LinearRows | None, iterations: int) -> Solution:
    stage = point_mass_in_air_stage(problem.quadrotor.rotor_count) if problem.full else point_mass_stage()
    shooting = Shooting.of(stage, problem, rows, thrust_ball=True)
    model = airframe_parameters(problem.quadrotor) if problem.full else np.array([problem.quadrotor.gravity, problem.drag])
    return solve(shooting, problem.waypoints, model, guess, _limits(problem, guess), barrier=BARRIER, iterations=iterations)


def guess_point_mass(problem: Problem, thrust: tuple[float, float, float] = UPRIGHT) -> Trajectory:
    """Straight lines or curves with a constant thrust, in units of the weight (world)."""
    durations, positions, velocities = straight_lines(problem)
    thrusts = np.tile(problem.quadrotor.gravity * np.array(thrust), (len(positions) - 1, 1))
    return Trajectory(durations, np.hstack([positions, velocities]), thrusts, problem.counts)


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
