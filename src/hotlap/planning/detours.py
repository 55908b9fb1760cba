"""Detours: the shortest way from point to point around solids, along straight lines between points beside them."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from itertools import pairwise
from typing import Protocol

import numpy as np

from hotlap.planning.linear_rows import Floats

SPACING = 0.02  # m between the places at which a straight line is tested
COARSE = 16  # places of the first test
ATTEMPTS = 400  # lines that may be found blocked before the search is given up


class Space(Protocol):
    """What a way keeps clear of."""

    def lacks(self, points: Floats) -> tuple[Floats, np.ndarray]:
        """How much too near points (n, 3) are to what is nearest [m], not positive where they are free; and its index."""
        ...

    def beside(self, index: int, heights: Floats) -> Floats:
        """Free places (k, 3) on all sides of a solid."""
        ...


def find_way(space: Space, start: Floats, end: Floats) -> Floats | None:
    """The shortest way found: corners (k, 3) with start and end; None where there is none.

    Only what blocks a line is looked at, and only lines of the shortest way are tested, until one is free.

    Args:
        space: what the way keeps clear of.
        start: shape (3,) [m] (world).
        end: likewise.
    """
    places, known, blocked = np.vstack([start, end]), set[int](), set[tuple[int, int]]()
    for _ in range(ATTEMPTS):
        way = _shortest(places, blocked)
        if way is None:
            return None
        free = True
        for one, other in pairwise(way):
            solid = _worst(space, places[one], places[other])
            if solid is None:
                continue
            free = False
            blocked.add((min(one, other), max(one, other)))
            if solid not in known:
                known.add(solid)
                places = np.vstack([places, space.beside(solid, np.array([start[2], end[2]]))])
        if free:
            return places[way]
    return None


def along(way: Floats, shares: Floats) -> tuple[Floats, Floats]:
    """Points (n, 3) at shares of the length of a way, and the unit vectors (n, 3) along it there."""
    steps = np.diff(way, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    marks = np.concatenate([[0.0], np.cumsum(lengths)])
    places = np.stack([np.interp(shares * marks[-1], marks, column) for column in way.T], axis=1)
    pieces = np.clip(np.searchsorted(marks, shares * marks[-1], side="left") - 1, 0, len(steps) - 1)
    return places, steps[pieces] / np.maximum(lengths[pieces], 1e-9)[:, None]


def _worst(space: Space, start: Floats, end: Floats) -> int | None:
    """The solid that a straight line is nearest to, where that is too near."""
    count = int(np.ceil(np.linalg.norm(end - start) / SPACING)) + 1
    shares = np.linspace(0, 1, count + 1)
    for some in (shares[:: max(count // COARSE, 1)], shares):  # most that are blocked are blocked at a few places already
        lacks, solids = space.lacks(start + some[:, None] * (end - start))
        if lacks.max() > 0:
            return int(solids[lacks.argmax()])
    return None


def _shortest(places: Floats, blocked: set[tuple[int, int]]) -> Sequence[int] | None:
    """Dijkstra's way from the first to the second place."""
    distances = np.linalg.norm(places[:, None] - places, axis=2)
    for one, other in blocked:
        distances[one, other] = distances[other, one] = np.inf
    best, before = np.full(len(places), np.inf), np.full(len(places), -1)
    best[0], queue, done = 0.0, [(0.0, 0)], set()
    while queue:
        length, place = heapq.heappop(queue)
        if place in done:
            continue
        done.add(place)
        if place == 1:
            break
        reached = length + distances[place]
        for other in np.flatnonzero(reached < best):
            best[other], before[other] = reached[other], place
            heapq.heappush(queue, (float(reached[other]), int(other)))
    if not np.isfinite(best[1]):
        return None
    way = [1]
    while way[-1] != 0:
        way.append(int(before[way[-1]]))
    return way[::-1]
