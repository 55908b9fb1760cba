"""Segmentation rules: ways to cut a reference into segments; `segmentation.SegmentationRule` names them.

By height, the paper's Sec. IV-C:

    heights -> class of each row -> pieces of at least 2 s -> steep pieces halved -> Segments

The paper leaves room; what is settled here, so that the counts come close to those of the authors' tuned data:

- The "successor" of a row is the row one second ahead, as in the released code: between neighbouring rows nothing rises by 1 m.
  In the last second it is the end.
- Pieces grow from left to right. One closes at the first row whose class differs from the class that it began with, once it has
  lasted 2 s; a last piece shorter than that joins its predecessor. Merging the shortest pieces first gives far too few.
- A piece is what most of its rows are. Neighbours of one class stay apart.
- The second half of a steep piece is split again only if it is steep itself.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hotlap.reference.reference import Reference
from hotlap.reference.segments import SegmentClass, Segments

# Sec. IV-C
AHEAD = 1.0  # s to a row's successor; the released code's window of 100 samples
RISE = 1.0  # m by which the successor of an ascent is higher
LEAST_PIECE = 2.0  # s that a piece lasts before it may close
STEEP_SLOPE = 1.0  # rise over run of a chord: tan(45 degrees)
LEAST_HALF = 1.0  # s that the halves of a steep piece last

TIE = 1e-9  # m: a rise of 1 m and a slope of 45 degrees are to mean the same wherever the track lies

BY_HEIGHT = {0: SegmentClass.FLAT, 1: SegmentClass.ASCENT, -1: SegmentClass.DESCENT}


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


def _height_kinds(height: NDArray[np.float64], threshold: float, ahead: int) -> NDArray[np.int64]:
    """1 where the reference is about to rise, -1 where it is about to fall, else 0; shape (rows,)."""
    successor = np.minimum(np.arange(len(height)) + ahead, len(height) - 1)
    rise = height[successor] - height
    return (rise >= threshold - TIE).astype(np.int64) - (rise <= -threshold + TIE)


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


def _rows(seconds: float, period: float) -> int:
    """A time in rows of a reference."""
    return max(1, round(seconds / period))
