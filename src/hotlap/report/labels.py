"""Labels: places for text beside points, where it covers neither lines nor other labels."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

ANGLES = np.linspace(0, 2 * np.pi, 16, endpoint=False)
WAYS_OUT = (1.0, 1.8, 2.8)  # distances to try, in gaps


@dataclass
class Placer:
    """Finds places for labels one after the other; all lengths in inches.

    Attributes:
        size: width and height of the drawing.
        path: shape (n, 2) points that should stay visible.
        occupied: boxes (centre x, centre y, half width, half height) where no label may be placed.
    """

    size: tuple[float, float]
    path: Floats
    occupied: list[tuple[float, float, float, float]] = field(default_factory=list)

    def place(self, point: Floats, width: float, height: float, gap: float) -> Floats:
        """Centre of the best place for a label of a given size beside a point, shape (2,).

        Args:
            point: shape (2,).
            width: of the label.
            height: of the label.
            gap: from the point to the nearest edge of the label.
        """
        half = np.array([width, height]) / 2
        best, least = point, np.inf
        for reach in WAYS_OUT:
            for angle in ANGLES:
                direction = np.array([np.cos(angle), np.sin(angle)])
                centre = point + direction * (reach * gap + np.abs(direction) @ half)
                cost = self._cost(centre, half) + 0.3 * (reach - 1)
                if cost < least - 1e-9:
                    best, least = centre, cost
        self.occupied.append((*best, *half))
        return best

    def block(self, centres: Floats, half: float) -> None:
        """Keep squares free of labels, shape (n, 2)."""
        self.occupied += [(x, y, half, half) for x, y in centres.tolist()]

    def _cost(self, centre: Floats, half: Floats) -> float:
        """The cost of a place: points of the path and labels that it would cover."""
        hidden = np.all(np.abs(self.path - centre) < half + 0.02, axis=1).sum()
        cost = float(np.sqrt(hidden))
        for x, y, half_width, half_height in self.occupied:
            overlap = np.minimum(half + np.array([half_width, half_height]) - np.abs(centre - np.array([x, y])), 2 * half)
            cost += 40.0 * float(np.prod(overlap) / np.prod(2 * half)) if (overlap > 0).all() else 0.0
        outside = np.maximum(half - centre, 0) + np.maximum(centre + half - self.size, 0)
        return cost + 200.0 * float(outside.sum())


def group(points: Floats, reach: float) -> list[tuple[Floats, list[int]]]:
    """Groups of points within a distance of the first point of their group: that point, and the indices of all members."""
    groups: list[tuple[Floats, list[int]]] = []
    for i, point in enumerate(points):
        near = next((members for first, members in groups if np.linalg.norm(point - first) < reach), None)
        if near is None:
            groups.append((point, [i]))
        else:
            near.append(i)
    return groups


def number(gates: Iterable[int], most: int = 3) -> str:
    """Gate numbers as a text, each once, consecutive numbers joined: "1, 4-6"; after `most` parts, dots."""
    parts: list[list[int]] = []
    for i in sorted(set(gates)):
        if parts and parts[-1][1] == i - 1:
            parts[-1][1] = i
        else:
            parts.append([i, i])
    texts = [str(a) if a == b else f"{a}{', ' if b == a + 1 else '–'}{b}" for a, b in parts]
    return ", ".join(texts[:most]) + ("…" if len(texts) > most else "")
