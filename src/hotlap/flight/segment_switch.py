"""Handing over: from when on a lane flies with the parameters of the next segment."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np
from numba import njit

from hotlap.flight.job import Job, Settings
from hotlap.flight.numbers import INLINE
from hotlap.race.race import SegmentSwitch

FRESH = -1  # piece of a lane that has not been controlled yet


class Mode(IntEnum):
    """`race.SegmentSwitch` as a number."""

    TIME = 0
    NODE = 1
    DISTANCE = 2


def mode_of(segment_switch: SegmentSwitch) -> Mode:
    """The number that compiled code takes."""
    return Mode[segment_switch.name]


BY_NODE, BY_DISTANCE = int(Mode.NODE), int(Mode.DISTANCE)


@njit(**INLINE)
def piece_at(row_pieces: np.ndarray, period: float, time: float) -> int:
    """The piece that the reference is in at a time [s]; the last row holds for ever."""
    return row_pieces[min(int(time / period + 1e-6), len(row_pieces) - 1)]


@njit(**INLINE)
def piece_flown(job: Job, s: Settings, seen: Any, k: int, before: int, time: float) -> int:
    """The piece whose parameters a lane flies with: the reference's, or the one that the drone has come to.

    Args:
        job: whose pieces.
        s: settings.
        seen: (10, lanes) states, raw.
        k: the lane.
        before: piece of the step before, or FRESH.
        time: [s] of the reference.
    """
    if s.segment_switch != BY_DISTANCE:
        return piece_at(job.row_pieces, s.table_period, time)
    if before == FRESH:
        return 0
    if before + 1 == len(job.piece_segments):
        return before
    square = 0.0
    for i in range(3):
        square += (seen[i, k] - job.piece_points[before + 1, i]) ** 2
    return before + 1 if square < s.segment_switch_distance**2 else before
