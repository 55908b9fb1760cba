"""Segmentation rules: ways to cut a reference into segments; `segmentation.Rule` names them.

By height, the paper's Sec. IV-C:

    heights -> class of each row -> pieces of at least 2 s -> steep pieces halved -> Segments

The paper leaves room; what is settled here, so that the counts come close to those of the authors' tuned data:

- The "successor" of a row is the row one second ahead, as in the released code: between neighbouring rows nothing rises by 1 m.
  In the last second it is the end.
- Pieces grow from left to right. One closes at the first row whose class differs from the class that it began with, once it has
  lasted 2 s; a last piece shorter than that joins its predecessor. Merging the shortest pieces first gives far too few.
- A piece is what most of its rows are. Neighbours of one class stay apart.
- The second half of a steep piece is split again only if it is steep itself.

By acceleration, our own: a tracking error grows where the velocity of the reference changes, and how depends on whether it changes
in length or in direction. With v and v' the velocities now and half a second later, and phi the angle between them:

    |v' - v|^2 = along^2 + across^2,    along = |v'| - |v|,    across = 2 sqrt(|v| |v'|) sin(phi / 2)

"cruise" where |v' - v| is small; else "turn" where across >= |along|, a "hard turn" where it needs more than 1 g, which is a bank of
45 degrees in level flight; else "acceleration" or "braking". All pieces of one class are one segment, so that there are five at most,
however long the track.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hotlap.reference import Reference
from hotlap.segments import SegmentClass, Segments

# Sec. IV-C
AHEAD = 1.0  # s to a row's successor; the released code's window of 100 samples
RISE = 1.0  # m by which the successor of an ascent is higher
LEAST_PIECE = 2.0  # s that a piece lasts before it may close
STEEP_SLOPE = 1.0  # rise over run of a chord: tan(45 degrees)
LEAST_HALF = 1.0  # s that the halves of a steep piece last

CHANGE_AHEAD = 0.5  # s over which a change of velocity is looked at
CHANGE_LEAST = 0.5  # s that a piece by acceleration lasts before it may close
CRUISE = 3.0  # m/s^2: below this mean acceleration nothing happens
HARD = 9.81  # m/s^2 across: tan(45 degrees) g

TIE = 1e-9  # m or m/s: a rise of 1 m and a slope of 45 degrees are to mean the same wherever the track lies

BY_HEIGHT = {0: SegmentClass.FLAT, 1: SegmentClass.ASCENT, -1: SegmentClass.DESCENT}
BY_ACCELERATION = (SegmentClass.CRUISE, SegmentClass.TURN, SegmentClass.HARD_TURN, SegmentClass.ACCELERATION, SegmentClass.BRAKING)


def by_height(
    reference: Reference, *, rise: float = RISE, ahead: float = AHEAD, least: float = LEAST_PIECE, slope: float = STEEP_SLOPE
) -> Segments:
    """Flat, ascent, descent and steep (Sec. IV-C of the paper).

    Segments last at least 1 s, and 2 s where nothing is steep; a plan shorter than 2 s is one segment. Differs from the paper's
    formula in sign: z is up here, so an ascent is what rises.

    Args:
        reference: its planned rows are cut.
        rise: [m] by which the successor of an ascent is higher.
        ahead: [s] to the successor.
        least: [s] that a piece lasts before it may close.
        slope: beyond which a chord is steep; infinity where nothing is to be halved.
    """
    position, period = reference.position[: reference.planned_rows], reference.period
    kinds = _height_kinds(position[:, 2], rise, _rows(ahead, period))
    pieces = []
    for first, last in pairwise(_borders(kinds, _rows(least, period))):
        pieces += _split(position, first, last, BY_HEIGHT[_majority(kinds[first:last])], slope, _rows(LEAST_HALF, period))
    starts, classes = zip(*pieces, strict=True)
    return Segments(np.array(starts) * period, classes, reference.duration)


def by_time(reference: Reference, *, piece: float = LEAST_PIECE) -> Segments:
    """As many pieces of equal time as last about `piece` [s] each; infinity for one. Classes as by height, what most rows are."""
    height, period = reference.position[: reference.planned_rows, 2], reference.period
    kinds, end = _height_kinds(height, RISE, _rows(AHEAD, period)), len(height) - 1
    borders = np.round(np.linspace(0, end, max(1, round(reference.duration / piece)) + 1)).astype(int).tolist()
    classes = tuple(BY_HEIGHT[_majority(kinds[first : max(last, first + 1)])] for first, last in pairwise(borders))
    return Segments(np.array(borders[:-1]) * period, classes, reference.duration)


def by_acceleration(
    reference: Reference, *, cruise: float = CRUISE, hard: float = HARD, ahead: float = CHANGE_AHEAD, least: float = CHANGE_LEAST
) -> Segments:
    """Cruise, turn, hard turn, acceleration and braking; the pieces of one class are one segment.

    Args:
        reference: its planned rows are cut.
        cruise: [m/s^2] mean acceleration below which nothing happens.
        hard: [m/s^2] mean acceleration across the velocity beyond which a turn is hard.
        ahead: [s] over which the velocity changes.
        least: [s] that a piece lasts before it may close; a shorter last one joins its predecessor.
    """
    period = reference.period
    kinds = _change_kinds(reference.velocity[: reference.planned_rows], cruise * ahead, hard * ahead, _rows(ahead, period))
    borders = _borders(kinds, _rows(least, period))
    each = [BY_ACCELERATION[_majority(kinds[first : max(last, first + 1)])] for first, last in pairwise(borders)]
    new = [i for i, kind in enumerate(each) if i == 0 or kind is not each[i - 1]]
    classes = tuple(each[i] for i in new)
    return Segments(np.array([borders[i] for i in new]) * period, classes, reference.duration, _owners(classes))


def _height_kinds(height: NDArray[np.float64], threshold: float, ahead: int) -> NDArray[np.int64]:
    """1 where the reference is about to rise, -1 where it is about to fall, else 0; shape (rows,)."""
    successor = np.minimum(np.arange(len(height)) + ahead, len(height) - 1)
    rise = height[successor] - height
    return (rise >= threshold - TIE).astype(np.int64) - (rise <= -threshold + TIE)


def _change_kinds(velocity: NDArray[np.float64], least: float, hard: float, ahead: int) -> NDArray[np.int64]:
    """Index in `BY_ACCELERATION` of each row, shape (rows,); the last rows, which have no successor, go on with what came before."""
    ahead = min(ahead, len(velocity) - 1)
    row = np.minimum(np.arange(len(velocity)), len(velocity) - 1 - ahead)
    change = np.linalg.norm(velocity[row + ahead] - velocity[row], axis=1)
    along = np.linalg.norm(velocity[row + ahead], axis=1) - np.linalg.norm(velocity[row], axis=1)
    across = np.sqrt(np.maximum(change**2 - along**2, 0.0))
    turning = across >= np.abs(along) - TIE
    return np.select([change < least - TIE, turning & (across <= hard + TIE), turning, along > 0], [0, 1, 2, 3], 4)


def _borders(kinds: NDArray[np.int64], least: int) -> list[int]:
    """Rows at which the pieces begin, and the last row."""
    borders, end = [0], len(kinds) - 1
    while True:
        first = borders[-1]
        changed = np.flatnonzero(kinds[first + least :] != kinds[first])
        if not len(changed) or first + least + changed[0] > end - least:
            return [*borders, end]
        borders.append(first + least + int(changed[0]))


def _majority(kinds: NDArray[np.int64]) -> int:
    """What most rows are; the first to come among equals, so that a mirrored reference gets mirrored classes."""
    values, firsts, counts = np.unique(kinds, return_index=True, return_counts=True)
    return int(values[min(range(len(values)), key=lambda i: (-counts[i], firsts[i]))])


def _split(
    position: NDArray[np.float64], first: int, last: int, kind: SegmentClass, slope: float, least: int
) -> list[tuple[int, SegmentClass]]:
    """Halve a piece while its chord is steep: first rows and classes."""
    across, along, up = position[last] - position[first]
    steep = math.isfinite(slope) and abs(up) > slope * np.hypot(across, along) + TIE
    if kind is SegmentClass.FLAT or not steep or last - first < 2 * least:
        return [(first, kind)]
    middle = (first + last) // 2
    return [(first, SegmentClass.STEEP), *_split(position, middle, last, kind, slope, least)]


def _owners(classes: Sequence[SegmentClass]) -> tuple[int, ...]:
    """One segment for each class, in order of their first pieces; empty where no class comes twice."""
    order = list(dict.fromkeys(classes))
    return tuple(order.index(kind) for kind in classes) if len(order) < len(classes) else ()


def _rows(seconds: float, period: float) -> int:
    """A time in rows of a reference."""
    return max(1, round(seconds / period))
