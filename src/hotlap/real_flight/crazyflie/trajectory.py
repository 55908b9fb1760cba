"""Trajectory: a reference as pieces of polynomials, as the high-level commander of a Crazyflie flies them.

    x(t) = c_0 + c_1 t + ... + c_7 t^7    in each piece, from its own beginning; likewise y, z and yaw

The pieces are a least-squares spline whose jerk is still continuous at the knots; there are as few as the error asks for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_lsq_spline

from hotlap.core.records import Floats

MOST = 31  # pieces that its memory takes
DEGREE, SMOOTH = 7, 4  # of a piece; derivatives from the zeroth on that go on over a knot
FEWEST, MORE = 4, 3  # pieces at first, and from one try to the next
FINE = 0.005  # m: an error that is small enough
ENDS = 100.0  # weight of the first and the last row, at which it stands


@dataclass(frozen=True)
class Trajectory:
    """Pieces, and how far they are from what they stand for.

    Attributes:
        durations: shape (n,) [s].
        coefficients: shape (n, 4, 8) of x, y, z [m], yaw [rad], the constant first.
        error: [m] at most.
        speed_error: [m/s] at most.
    """

    durations: Floats
    coefficients: Floats
    error: float
    speed_error: float

    @property
    def words(self) -> str:
        """For people."""
        return f"{len(self.durations)} pieces, at most {1e3 * self.error:.0f} mm and {self.speed_error:.2f} m/s from the plan"


def fit(times: Floats, states: Floats, fine: float = FINE, most: int = MOST) -> Trajectory:
    """The trajectory of a reference.

    Args:
        times: shape (rows,) [s], from 0 on.
        states: shape (rows, 13).
        fine: [m] error from which on no more pieces are tried.
        most: pieces at most.
    """
    w, x, y, z = states[:, 3:7].T
    yaw = np.unwrap(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
    wanted = np.column_stack([states[:, :3], yaw])
    most = min(most, max((len(times) - DEGREE - 1) // (2 * SMOOTH), 1))  # a knot wants rows
    best = _fit(times, wanted, states[:, 7:10], min(FEWEST, most))
    for count in sorted({min(count, most) for count in range(FEWEST + MORE, most + MORE, MORE)}):
        if best.error < fine:
            break
        best = min(best, _fit(times, wanted, states[:, 7:10], count), key=lambda one: one.error)
    return best


def _fit(times: Floats, wanted: Floats, velocity: Floats, count: int) -> Trajectory:
    """With a number of pieces, all as long."""
    ends = np.linspace(times[0], times[-1], count + 1)
    knots = np.concatenate([np.full(DEGREE + 1, ends[0]), np.repeat(ends[1:-1], DEGREE + 1 - SMOOTH), np.full(DEGREE + 1, ends[-1])])
    weights = np.ones(len(times))
    weights[[0, -1]] = ENDS
    spline = make_lsq_spline(times, wanted, knots, k=DEGREE, w=weights)
    error = float(np.linalg.norm(spline(times)[:, :3] - wanted[:, :3], axis=1).max())
    speed_error = float(np.linalg.norm(spline.derivative()(times)[:, :3] - velocity, axis=1).max())
    coefficients = [spline(ends[:-1], nu=power) / math.factorial(power) for power in range(DEGREE + 1)]
    return Trajectory(np.diff(ends), np.stack(coefficients, axis=-1), error, speed_error)
