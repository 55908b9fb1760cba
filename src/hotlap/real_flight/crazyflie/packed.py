"""Packed: states as a Crazyflie logs them, in whole thousandths, with a quaternion in 32 bits.

Of a unit quaternion (x, y, z, w) the largest component is left out: two bits say which, and ten bits each hold sign and size of the
others, in 511ths of sqrt(1/2). World and body are hotlap's own (z up; x forward, y left), but for the pitch rate, which is logged with
the other sign.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hotlap.core.records import Floats

MILLI = 1e-3
MOST = 32.767  # m, m/s, rad/s: of a number in 16 bits
STEPS, BITS = 511, 10
PITCH = np.array([1.0, -1.0, 1.0])


def unpack_attitude(packed: int) -> Floats:
    """The attitude (w, x, y, z), shape (4,), of 32 bits."""
    largest, parts = packed >> 30, np.zeros(4)
    for i in reversed([i for i in range(4) if i != largest]):
        size = (packed & STEPS) / STEPS * math.sqrt(0.5)
        parts[i] = -size if packed >> (BITS - 1) & 1 else size
        packed >>= BITS
    parts[largest] = math.sqrt(max(1.0 - float(parts @ parts), 0.0))
    return np.roll(parts, 1)


def pack_attitude(attitude: Floats) -> int:
    """The 32 bits of an attitude (w, x, y, z), shape (4,)."""
    parts = np.roll(attitude / np.linalg.norm(attitude), -1)
    largest = int(np.argmax(np.abs(parts)))
    parts = parts if parts[largest] >= 0 else -parts
    packed = largest
    for i in range(4):
        if i != largest:
            size = int(STEPS * abs(float(parts[i])) / math.sqrt(0.5) + 0.5)
            packed = packed << BITS | int(parts[i] < 0) << (BITS - 1) | size
    return packed


def unpack_state(values: Sequence[int]) -> Floats:
    """The state, shape (13,), of what is logged: position, velocity, attitude, rates; ten whole numbers."""
    numbers = MILLI * np.array(values, dtype=np.float64)
    return np.concatenate([numbers[:3], unpack_attitude(int(values[6])), numbers[3:6], numbers[7:10] * PITCH])


def pack_state(state: Floats) -> list[int]:
    """What is logged of a state, shape (13,)."""
    numbers = np.clip(np.concatenate([state[:3], state[7:10], state[10:13] * PITCH]), -MOST, MOST)
    whole = np.round(numbers / MILLI).astype(int).tolist()
    return [*whole[:6], pack_attitude(state[3:7]), *whole[6:]]
