"""Guesses of a way through openings: curves that leave and reach gates along their normals."""

from __future__ import annotations

import numpy as np

from hotlap.planning.problem import Floats, Problem

Pair = Floats | tuple[Floats, Floats]
SHORTEST_GUESS = 0.1  # s, of a phase from gate to gate
SLOWER = 1.2  # curves are longer than straight lines


def guessed_speed(problem: Problem) -> float:
    """[m/s] of a point mass between targets of the usual distance."""
    usual = np.median(problem.legs[[not target.inside for target in problem.targets]])
    speed = float(np.sqrt(0.5 * problem.level_acceleration * usual)) + 1.0
    return min(speed, 0.6 * problem.level_acceleration / problem.drag) if problem.drag > 0 else speed


def along_normals(problem: Problem) -> tuple[Floats, Floats, Floats]:
    """Cubic curves from target to target, along the normals of gates.

    Returns:
        Durations (M,) [s]; positions (N + 1, 3) [m] and velocities (N + 1, 3) [m/s] (world).
    """
    durations = SLOWER * problem.legs / guessed_speed(problem)
    least = np.where([target.inside for target in problem.targets], 0.0, SHORTEST_GUESS)
    durations = np.maximum(durations, least)
    points, tangents = problem.points, _tangents(problem, durations)
    counts = problem.counts or (problem.intervals,) * problem.phases
    positions, velocities = [points[:1]], [problem.start_velocity[None]]
    for k, (duration, count) in enumerate(zip(durations, counts, strict=True)):
        place, velocity = hermite(np.arange(1, count + 1) / count, duration, points[k : k + 2], tangents[k : k + 2])
        positions.append(place)
        velocities.append(velocity)
    return durations, np.vstack(positions), np.vstack(velocities)


def hermite(shares: Floats, duration: float | Floats, points: Pair, velocities: Pair) -> tuple[Floats, Floats]:
    """Cubic curves between two points with given velocities: positions and velocities at shares of their time.

    Args:
        shares: shape (count,), from 0 to 1.
        duration: [s] of the curve, one for all or shape (count, 1).
        points: shape (2, 3) or (2, count, 3) [m] at its ends.
        velocities: likewise [m/s].
    """
    s, t0, t1 = shares[:, None], velocities[0] * duration, velocities[1] * duration
    place = (2 * s**3 - 3 * s**2 + 1) * points[0] + (s**3 - 2 * s**2 + s) * t0 + (3 * s**2 - 2 * s**3) * points[1] + (s**3 - s**2) * t1
    slope = (6 * s**2 - 6 * s) * (points[0] - points[1]) + (3 * s**2 - 4 * s + 1) * t0 + (3 * s**2 - 2 * s) * t1
    return place, slope / duration


def _tangents(problem: Problem, durations: Floats) -> Floats:
    """Velocities at start and targets, shape (M + 1, 3) [m/s] (world)."""
    mean = np.diff(problem.points, axis=0) / durations[:, None]
    speeds = np.linalg.norm(mean, axis=1)
    after = np.vstack([mean[1:], mean[-1:]])
    tangents = [problem.start_velocity]
    for k, target in enumerate(problem.targets):
        directed = target.plane is not None and (target.plane.one_way or target.along != 0)
        slower = min(speeds[k], speeds[min(k + 1, len(speeds) - 1)])
        tangents.append(target.plane.normal * slower if directed and target.plane else 0.5 * (mean[k] + after[k]))
    if problem.end_at_rest:
        tangents[-1] = np.zeros(3)
    return np.array(tangents)
