"""Bounds: heights and walls that the nodes of a plan keep to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hotlap.planning.problem import Floats, Problem


def bound_positions(problem: Problem, intervals: NDArray[np.intp], low: Floats, high: Floats) -> None:
    """Set the bounds of positions and of the velocity at start and end.

    The vehicle keeps clear of ceiling and box by its margin; the floor is for its centre, since a drone may start on it. Where the start or
    a target lies closer, the phases before and behind it may come as close.

    Args:
        problem: what is planned.
        intervals: of each phase, shape (M,).
        low: least states, shape (N + 1, nx); written to.
        high: largest states, likewise.
    """
    low[:, 2] = problem.floor
    if np.isfinite(problem.walls).any():
        points, owners = problem.points, np.repeat(np.arange(problem.phases), intervals)
        owners = np.append(owners[:1], owners)
        nearest, furthest = np.minimum(points[:-1], points[1:]), np.maximum(points[:-1], points[1:])
        least = np.minimum(problem.walls[0] + problem.margin, nearest)[owners]
        low[:, :3] = np.maximum(low[:, :3], least)
        high[:, :3] = np.maximum(problem.walls[1] - problem.margin, furthest)[owners]
    low[0, :3] = high[0, :3] = problem.start
    low[0, 3:6] = high[0, 3:6] = problem.start_velocity
    if problem.end_at_rest:
        low[-1, 3:6] = high[-1, 3:6] = 0.0
