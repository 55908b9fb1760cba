"""Held: a signal that keeps its value until the next sample, and its means."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hotlap.core.records import Floats


@dataclass(frozen=True)
class Held:
    """A command that holds until the next one.

    Attributes:
        times: shape (N,) [s].
        values: shape (N, D).
    """

    times: Floats
    values: Floats

    def means(self, edges: Floats, values: Floats | None = None) -> Floats:
        """Means between edges, shape (len(edges) - 1, D); before the first sample and after the last these are held.

        Args:
            edges: [s], increasing.
            values: in place of the own ones, shape (N, D).
        """
        held = self.values if values is None else values
        spans = np.diff(self.times)
        sums = np.vstack([np.zeros(held.shape[1]), np.cumsum(held[:-1] * spans[:, None], axis=0)])
        ends = np.concatenate([[self.times[0] - 1e3], self.times, [self.times[-1] + 1e3]])
        columns = []
        for d in range(held.shape[1]):
            total = np.concatenate([[-1e3 * held[0, d]], sums[:, d], [sums[-1, d] + 1e3 * held[-1, d]]])
            columns.append(np.diff(np.interp(edges, ends, total)) / np.diff(edges))
        return np.column_stack(columns)
