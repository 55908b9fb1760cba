"""Warm starts: straight lines from point to point, and the full state around a point-mass plan."""

from __future__ import annotations

import numpy as np

from hotlap.planning.guess import along_normals
from hotlap.planning.problem import Floats, Problem, Trajectory
from hotlap.reference.attitude import follow_axes, product, turn_rates

SHORTEST_GUESS = 0.1  # s, of a phase


def straight_lines(problem: Problem) -> tuple[Floats, Floats, Floats]:
    """Straight legs at one guessed speed.

    Returns:
        Durations (M,) [s]; positions (N + 1, 3) [m] and velocities (N + 1, 3) [m/s] (world), as the start asks for at the first node.
    """
    if problem.has_openings:
        return along_normals(problem)
    speed = np.sqrt(0.5 * problem.level_acceleration * np.median(problem.legs)) + 1.0
    if problem.full:
        speed = min(speed, 0.6 * problem.top_speed)
    elif problem.drag > 0:
        speed = min(speed, 0.6 * problem.level_acceleration / problem.drag)
    durations = np.maximum(problem.legs / speed, SHORTEST_GUESS)
    legs = np.repeat(np.diff(problem.points, axis=0), problem.intervals, axis=0)
    positions = np.vstack([problem.start, problem.start + np.cumsum(legs / problem.intervals, axis=0)])
    velocities = legs / np.repeat(durations, problem.intervals)[:, None]
    velocities = np.vstack([problem.start_velocity, velocities])
    if problem.end_at_rest:
        velocities[-1] = 0.0
    return durations, positions, velocities


def hover_along(problem: Problem, *, inverted: bool = False) -> Trajectory:
    """Straight lines of the full quadrotor with the thrust of hover, in the attitude of the start or turned over from it."""
    durations, positions, velocities = straight_lines(problem)
    quadrotor, count = problem.quadrotor, len(positions)
    attitudes, rates = np.tile(problem.attitude, (count, 1)), np.zeros((count, 3))
    if inverted:
        attitudes[1:] = product(problem.attitude, np.array([0.0, 1.0, 0.0, 0.0]))  # half a turn about body x
    thrusts = np.full((count - 1, quadrotor.rotor_count), quadrotor.mass * quadrotor.gravity / quadrotor.rotor_count)
    return Trajectory(durations, np.hstack([positions, velocities, attitudes, rates]), thrusts, problem.counts)


def around_point_mass(problem: Problem, plan: Trajectory) -> Trajectory:
    """The full quadrotor that tilts its thrust as a point-mass plan does, turning about body z as little as possible.

    Args:
        problem: what is planned.
        plan: of the point mass, any number of intervals.
    """
    frame = Trajectory(plan.durations, np.empty(0), np.empty((problem.intervals_in_all, problem.quadrotor.rotor_count)), problem.counts)
    times, middles = frame.times, 0.5 * (plan.times[1:] + plan.times[:-1])
    motion = np.stack([np.interp(times, plan.times, column) for column in plan.states.T], axis=1)
    accelerations = np.stack([np.interp(times, middles, column) for column in plan.controls.T], axis=1)
    thrusts = np.linalg.norm(accelerations, axis=1)
    axes = accelerations / np.maximum(thrusts, 1e-6)[:, None]
    attitudes = np.vstack([problem.attitude, follow_axes(axes[1:], problem.attitude)])
    quadrotor, rotors = problem.quadrotor, problem.quadrotor.rotor_count
    largest = 0.9 * np.array(quadrotor.rate_limit)
    rates = np.vstack([turn_rates(attitudes, np.maximum(frame.steps, 1e-3)), np.zeros(3)])
    rates = np.clip(rates, -largest, largest)
    rotor_thrusts = np.repeat(thrusts[:-1, None] * quadrotor.mass / rotors, rotors, axis=1)
    return Trajectory(plan.durations, np.hstack([motion, attitudes, rates]), rotor_thrusts, problem.counts)
