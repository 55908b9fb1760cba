"""Between the rows of a file a flight goes on as positions and velocities say."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from hotlap.reference_files.resampling import resample


def test_positions_between_coarse_rows_follow_cubics_exactly():
    times = np.array([0.0, 0.1, 0.15, 0.4])
    values = np.zeros((4, 24))
    values[:, 4] = 1.0
    values[:, 1], values[:, 8] = times**3 - times**2, 3 * times**2 - 2 * times
    at = np.linspace(0, 0.4, 33)
    assert_allclose(resample(times, values, at)[:, 1], at**3 - at**2, atol=1e-14)
