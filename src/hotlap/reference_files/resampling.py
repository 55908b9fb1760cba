"""Resampling: what a file says between its rows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hotlap.reference_files.table import ATTITUDE, POSITION, THRUSTS, VELOCITY

Floats = NDArray[np.float64]


def between(times: Floats, position: Floats, velocity: Floats, at: Floats) -> tuple[Floats, Floats]:
    """Positions by cubics with the right velocities, and velocities linearly, at other times, shapes (at, 3)."""
    rows = np.clip(np.searchsorted(times, at + 1e-9, side="right") - 1, 0, len(times) - 2)
    steps = (times[rows + 1] - times[rows])[:, None]
    share = np.clip((at - times[rows])[:, None] / steps, 0.0, 1.0)
    p0, p1, v0, v1 = position[rows], position[rows + 1], velocity[rows] * steps, velocity[rows + 1] * steps
    positions = p0 + share * v0 + share**2 * (3 * (p1 - p0) - 2 * v0 - v1) + share**3 * (2 * (p0 - p1) + v0 + v1)
    return positions, velocity[rows] + share * (velocity[rows + 1] - velocity[rows])


def resample(times: Floats, values: Floats, at: Floats) -> Floats:
    """Rows at other times: positions by cubics with the right velocities, thrusts held, the rest linearly.

    Args:
        times: shape (rows,) [s], ascending.
        values: shape (rows, 24), as in `Table`.
        at: shape (n,) [s] the other times, within those of the rows.

    Returns:
        Shape (n, 24).
    """
    rows = np.clip(np.searchsorted(times, at + 1e-9, side="right") - 1, 0, len(times) - 2)
    steps = (times[rows + 1] - times[rows])[:, None]
    share = np.clip((at - times[rows])[:, None] / steps, 0.0, 1.0)
    before, after = values[rows], values[rows + 1]
    result = before + share * (after - before)
    result[:, POSITION] = between(times, values[:, POSITION], values[:, VELOCITY], at)[0]
    norms = np.linalg.norm(result[:, ATTITUDE], axis=1, keepdims=True)
    result[:, ATTITUDE] /= np.where(np.abs(norms - 1) > 1e-12, norms, 1.0)
    result[:, THRUSTS] = np.where(share < 1.0, before, after)[:, THRUSTS]
    return result
