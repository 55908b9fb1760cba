"""Linear rows: what positions and velocities at nodes must keep to."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LinearRows:
    """Rows low <= coefficients . (p, v) <= high.

    Attributes:
        nodes: shape (rows,) at which node each of them holds.
        coefficients: shape (rows, 6) of position and velocity (world).
        low, high: shape (rows,); infinite where there is no bound.
    """

    nodes: NDArray[np.intp]
    coefficients: Floats
    low: Floats
    high: Floats

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(self.nodes)

    @classmethod
    def none(cls) -> LinearRows:
        """No rows."""
        return cls(np.empty(0, dtype=np.intp), np.empty((0, 6)), np.empty(0), np.empty(0))

    @classmethod
    def of(cls, node: int, coefficients: Floats, low: float | Floats, high: float | Floats) -> LinearRows:
        """Rows of one node: coefficients of positions (rows, 3), or of positions and velocities (rows, 6)."""
        rows = np.atleast_2d(coefficients)
        if rows.shape[1] == 3:
            rows = np.hstack([rows, np.zeros_like(rows)])
        count = len(rows)
        return cls(np.full(count, node, dtype=np.intp), rows, np.broadcast_to(low, count).copy(), np.broadcast_to(high, count).copy())

    @classmethod
    def joined(cls, parts: Iterable[LinearRows]) -> LinearRows:
        """All rows of several."""
        parts = [cls.none(), *parts]
        return cls(
            np.concatenate([part.nodes for part in parts]),
            np.vstack([part.coefficients for part in parts]),
            np.concatenate([part.low for part in parts]),
            np.concatenate([part.high for part in parts]),
        )
