"""Segment switch: at which moment the controller takes the parameters of the next segment."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from hotlap.flight.job import Job, Settings
from hotlap.flight.numbers import INLINE
from hotlap.race.race import SegmentSwitch

FRESH = -1  # piece of the reference of a lane before its first control step
BY_TIME, BY_NODE, BY_DISTANCE = range(3)  # `race.SegmentSwitch` as compiled code knows it
_NUMBERS = {SegmentSwitch.TIME: BY_TIME, SegmentSwitch.NODE: BY_NODE, SegmentSwitch.DISTANCE: BY_DISTANCE}


def switch_number(segment_switch: SegmentSwitch) -> int:
    """The number by which compiled code knows a way to switch."""
    return _NUMBERS[segment_switch]


@njit(**INLINE)
def piece_at(row_pieces: np.ndarray, period: float, time: float) -> int:
    """The piece that the reference is in at a time [s]: that of the last row before it; a piece begins at a row."""
    return row_pieces[min(int(time / period + 1e-6), len(row_pieces) - 1)]


@njit(**INLINE)
def piece_flown(job: Job, s: Settings, seen: Any, k: int, before: int, time: float) -> int:
    """The piece whose parameters a lane flies with: that of the reference, or the one that the drone has come close to.

    Args:
        job: the batch, with the pieces of its reference.
        s: its settings.
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
