"""The full plan: a quadrotor with single-rotor thrust limits, from a warm start."""

from __future__ import annotations

import dataclasses

import numpy as np

from hotlap.planning.bounds import bound_positions
from hotlap.planning.full_stage import BODY, ROTORS, full_parameters, full_stage_of, hover_thrust, limit_start_and_commands, with_rotors
from hotlap.planning.ipopt import Limits, Solution, solve
from hotlap.planning.linear_rows import LinearRows
from hotlap.planning.problem import LONGEST, Floats, Problem, Trajectory
from hotlap.planning.shooting import Shooting
from hotlap.planning.stage import ATTITUDE, Stage, quadrotor_stage

RATES = slice(10, 13)  # of the full state
LEVEL = [7, 8, 10, 11, 12]  # of the full state: zero where it is level and turns no more
RAMP_PASSES = 4
SETTLED = 2e-4  # relative change of the duration from one ramp pass to the next


def stage_of(problem: Problem) -> Stage:
    """The stage that a problem is planned with."""
    return full_stage_of(problem) if problem.full else quadrotor_stage(problem.quadrotor.rotor_count)


def model_parameters(problem: Problem) -> Floats:
    """Parameters of the stage that a problem is planned with."""
    if problem.full:
        return full_parameters(problem)
    quadrotor = problem.quadrotor
    return np.concatenate([
        [quadrotor.mass, quadrotor.gravity, problem.drag],
        quadrotor.inertia_vector,
        quadrotor.torque_matrix.ravel(),
    ])  # fmt: skip


def rotor_thrusts(problem: Problem, states: Floats, controls: Floats) -> Floats:
    """Thrusts [N] of the rotors where states and controls are given: the controls, unless the motors lag."""
    return states[:, ROTORS] if problem.full else controls


def plan_quadrotor(problem: Problem, guess: Trajectory, *, barrier: float, iterations: int, rows: LinearRows | None = None) -> Solution:
    """The fastest way for the quadrotor; with a ramp, planned again until the limits fit the durations.

    Args:
        problem: what is planned.
        guess: states (position, velocity, attitude, rates), controls rotor thrusts [N].
        barrier: as in `solve`.
        iterations: likewise.
        rows: what nodes keep to besides the openings.
    """
    shooting = Shooting.of(stage_of(problem), problem, rows)
    model = model_parameters(problem)
    passes = 0
    while True:
        guess, limits = _limited(problem, guess)
        solution = solve(shooting, problem.waypoints, model, guess, limits, barrier=barrier, iterations=iterations)
        passes += 1
        settled = abs(solution.trajectory.duration / guess.duration - 1) < SETTLED
        if problem.ramp is None or settled or not solution.converged or passes == RAMP_PASSES:
            return solution
        guess = solution.trajectory


def ramped_limits(problem: Problem, plan: Trajectory) -> tuple[Floats, Floats]:
    """Largest rotor thrust [N] of each interval, shape (N,), and roll and pitch rates [rad/s] at each node, shape (N + 1, 2).

    A ramp grows with L t / T, where L is the length of the waypoints' polyline and T the plan's duration: rpg_time_optimal
    ramps by the index of its nodes, which are uniform in time.
    """
    quadrotor, ramp, times = problem.quadrotor, problem.ramp, plan.times
    thrust, rates = quadrotor.rotor_thrust[1], np.array(quadrotor.rate_limit[:2])
    if ramp is None:
        return np.full(len(times) - 1, thrust), np.tile(rates, (len(times), 1))
    share = np.minimum(times / times[-1] * problem.legs.sum() / ramp.distance, 1.0)
    first_thrust = min(ramp.thrust_to_weight * quadrotor.mass * quadrotor.gravity / quadrotor.rotor_count, thrust)
    first_rates = np.minimum(ramp.rate, rates)
    return first_thrust + (thrust - first_thrust) * share[:-1], first_rates + (rates - first_rates) * share[:, None]


def _limited(problem: Problem, guess: Trajectory) -> tuple[Trajectory, Limits]:
    """The guess from the start's state and within the limits, and the limits."""
    quadrotor = problem.quadrotor
    thrust, rates = ramped_limits(problem, guess)
    if problem.full and guess.states.shape[1] == BODY.stop:
        guess = with_rotors(problem, guess)
    low, high = np.full(guess.states.shape, -np.inf), np.full(guess.states.shape, np.inf)
    low[:, ATTITUDE], high[:, ATTITUDE] = -1.01, 1.01
    high[:, RATES] = np.hstack([rates, np.full((len(rates), 1), quadrotor.rate_limit[2])])
    low[:, RATES] = -high[:, RATES]
    low[0, ATTITUDE] = high[0, ATTITUDE] = problem.attitude  # the first rates are free
    bound_positions(problem, guess.intervals, low, high)
    if problem.end_at_rest:
        low[-1, LEVEL], high[-1, LEVEL] = 0.0, 0.0
    if problem.full:
        limit_start_and_commands(problem, low, high)
    if problem.full and problem.end_at_rest:
        low[-1, ROTORS] = high[-1, ROTORS] = hover_thrust(problem)
    least, largest = np.full(guess.controls.shape, quadrotor.rotor_thrust[0]), np.repeat(thrust[:, None], quadrotor.rotor_count, axis=1)
    margin = 0.01 * (largest - least)
    states = guess.states.copy()
    fixed = low[0] == high[0]
    states[0, fixed] = low[0, fixed]
    guess = dataclasses.replace(guess, states=states, controls=np.clip(guess.controls, least + margin, largest - margin))
    ones = np.ones(problem.phases)
    return guess, Limits(Trajectory(problem.shortest, low, least), Trajectory(LONGEST * ones, high, largest), problem.radii)
