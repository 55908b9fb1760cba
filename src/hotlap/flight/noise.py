"""Noise: random numbers that depend on the flight's seed, the control step and the channel alone, never on batch, lane or order."""

from __future__ import annotations

import numpy as np
from numba import njit

CHANNELS = 64  # a step
THRUST, RATES, WIND, MEASURED = 0, 1, 4, 7  # channels of every step: 1, 3, 3 and 9 of them
POSITION, VELOCITY, ATTITUDE, BIAS, HEADING = 16, 20, 24, 28, 32  # channels of step 0: 3, 3, 3, 1 and 2


@njit(inline="always")
def normal(seed: int, step: int, channel: int) -> float:
    """A number of mean 0 and variance 1: the sum of four uniform ones, nearly Gaussian and never beyond 3.47.

    The four are the 16-bit parts of a hash of (seed, step, channel): splitmix64's finaliser (Steele, Lea, Flood, OOPSLA 2014).
    """
    hashed = np.uint64(seed) * np.uint64(0x9E3779B97F4A7C15)
    hashed += np.uint64(step * CHANNELS + channel) * np.uint64(0xD1B54A32D192ED03) + np.uint64(0x632BE59BD9B4E019)
    hashed ^= hashed >> np.uint64(30)
    hashed *= np.uint64(0xBF58476D1CE4E5B9)
    hashed ^= hashed >> np.uint64(27)
    hashed *= np.uint64(0x94D049BB133111EB)
    hashed ^= hashed >> np.uint64(31)
    part = np.uint64(0xFFFF)
    total = np.int64(hashed & part) + np.int64((hashed >> np.uint64(16)) & part)
    total += np.int64((hashed >> np.uint64(32)) & part) + np.int64(hashed >> np.uint64(48))
    return (total / 65536.0 - (2.0 - 2.0 / 65536.0)) * 1.7320508075688772  # uniform parts have mean (1 - 2^-16) / 2, variance 1 / 12
