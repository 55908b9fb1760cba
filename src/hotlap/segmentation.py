"""Segments: the parts of a reference that have parameters of their own (Sec. IV-C of the paper).

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

from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hotlap.reference import Reference

# Sec. IV-C
AHEAD = 1.0  # s to a row's successor; the released code's window of 100 samples
RISE = 1.0  # m by which the successor of an ascent is higher
LEAST_PIECE = 2.0  # s that a piece lasts before it may close
STEEP_SLOPE = 1.0  # rise over run of a chord: tan(45 degrees)
LEAST_HALF = 1.0  # s that the halves of a steep piece last

TIE = 1e-9  # m: a rise of 1 m and a slope of 45 degrees are to mean the same wherever the track lies


class SegmentClass(StrEnum):
    """What a part of a reference does."""

    FLAT = "flat"
    ASCENT = "ascent"
    DESCENT = "descent"
    STEEP = "steep"


@dataclass(frozen=True)
class Segments:
    """Consecutive parts of a reference.

    Attributes:
        starts: [s] shape (S,), ascending; the first is 0.
        classes: S classes.
        duration: [s] end of the last segment.
    """

    starts: NDArray[np.float64]
    classes: tuple[SegmentClass, ...]
    duration: float

    def __len__(self) -> int:
        """S, the number of segments."""
        return len(self.classes)

    @property
    def ends(self) -> NDArray[np.float64]:
        """[s] shape (S,)."""
        return np.append(self.starts[1:], self.duration)

    def at(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """Index of the segment at each time [s]; the last one holds for ever."""
        return np.clip(np.searchsorted(self.starts, times, side="right") - 1, 0, len(self) - 1)


def segment(reference: Reference) -> Segments:
    """Cut a plan into segments of one class each (Sec. IV-C of the paper); its run-out belongs to the last one.

    Segments last at least 1 s, and 2 s where nothing is steep; a plan shorter than 2 s is one segment. Differs from the paper's
    formula in sign: z is up here, so an ascent is what rises.
    """
    position, period = reference.position[: reference.planned_rows], reference.period
    kinds = _kinds(position[:, 2], _rows(AHEAD, period))
    borders = _borders(kinds, _rows(LEAST_PIECE, period))
    pieces = []
    for first, last in pairwise(borders):
        pieces += _split(position, first, last, _majority(kinds[first:last]), _rows(LEAST_HALF, period))
    starts, classes = zip(*pieces, strict=True)
    return Segments(np.array(starts) * period, classes, reference.duration)


def _kinds(height: NDArray[np.float64], ahead: int) -> NDArray[np.int64]:
    """1 where the reference is about to rise, -1 where it is about to fall, else 0; shape (rows,)."""
    successor = np.minimum(np.arange(len(height)) + ahead, len(height) - 1)
    rise = height[successor] - height
    return (rise >= RISE - TIE).astype(np.int64) - (rise <= -RISE + TIE)


def _borders(kinds: NDArray[np.int64], least: int) -> list[int]:
    """Rows at which the pieces begin, and the last row."""
    borders, end = [0], len(kinds) - 1
    while True:
        first = borders[-1]
        changed = np.flatnonzero(kinds[first + least :] != kinds[first])
        if not len(changed) or first + least + changed[0] > end - least:
            return [*borders, end]
        borders.append(first + least + int(changed[0]))


def _majority(kinds: NDArray[np.int64]) -> SegmentClass:
    """What most rows are; the first to come among equals, so that a mirrored reference gets mirrored classes."""
    values, firsts, counts = np.unique(kinds, return_index=True, return_counts=True)
    winner = min(range(len(values)), key=lambda i: (-counts[i], firsts[i]))
    return {0: SegmentClass.FLAT, 1: SegmentClass.ASCENT, -1: SegmentClass.DESCENT}[int(values[winner])]


def _split(position: NDArray[np.float64], first: int, last: int, kind: SegmentClass, least: int) -> list[tuple[int, SegmentClass]]:
    """Halve a piece while its chord is steep: first rows and classes."""
    across, along, up = position[last] - position[first]
    steep = abs(up) > STEEP_SLOPE * np.hypot(across, along) + TIE
    if kind is SegmentClass.FLAT or not steep or last - first < 2 * least:
        return [(first, kind)]
    middle = (first + last) // 2
    return [(first, SegmentClass.STEEP), *_split(position, middle, last, kind, least)]


def _rows(seconds: float, period: float) -> int:
    """A time in rows of a reference."""
    return max(1, round(seconds / period))
