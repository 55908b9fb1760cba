"""Draws: vehicles around a base, whose numbers an identification should find."""

from __future__ import annotations

import numpy as np

from hotlap.race.quadrotor import Quadrotor

OFF, HEAVIER = 0.3, 0.15  # of a logarithm, at most
DELAYS = tuple(0.0025 * k for k in range(4, 20))  # s


def drawn(base: Quadrotor, seed: int) -> tuple[Quadrotor, float]:
    """A vehicle around the base, and its dead time [s]: gains, lags and drag up to a third off, mass up to 16 %, 10 to 47.5 ms.

    Args:
        base: as its pilot knows it.
        seed: of the draw.
    """
    random = np.random.default_rng(seed)

    def off(most: float = OFF) -> float:
        return float(np.exp(random.uniform(-most, most)))

    change = {
        "mass": base.mass * off(HEAVIER),
        "rate_gain": tuple(gain * off() for gain in base.rate_gain),
        "motor_time": tuple(time * off() for time in base.motor_time),
        "drag": tuple(drag * off() for drag in base.drag),
    }
    return base.model_copy(update=change), DELAYS[int(random.integers(len(DELAYS)))]
