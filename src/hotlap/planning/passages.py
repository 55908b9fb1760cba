"""Passages: when a flight passes each gate of a track, found from its positions alone."""

from __future__ import annotations

import numpy as np

from hotlap.planning.problem import Floats


class MissedGateError(ValueError):
    """A gate that is not passed in its turn.

    Args:
        gate: its index.
        reason: in one clause.
    """

    def __init__(self, gate: int, reason: str) -> None:
        self.gate, self.reason = gate, reason
        super().__init__(f"gate {gate}: {reason}")


def find_passages(times: Floats, position: Floats, velocity: Floats, gates: Floats, distance: float) -> Floats:
    """Times at which the gates are passed, one after the other, shape (gates,) [s].

    A flight may come near a gate several times, and a track may have the same gate several times. Of all ascending choices of
    local closest approaches, that with the least sum of squared distances is taken (dynamic programming): going from gate to
    gate and always taking the next approach would take a fly-by for the passage.

    Args:
        times: shape (rows,) [s].
        position: shape (rows, 3) [m] (world).
        velocity: shape (rows, 3) [m/s] (world).
        gates: shape (gates, 3) [m] (world).
        distance: [m] how close is close enough.

    Raises:
        MissedGateError: for the first gate that is not passed closely enough, or not in its turn.
    """
    chosen: list[tuple[Floats, Floats, np.ndarray]] = []  # of each gate: times, least costs so far, choice for the gate before
    for gate, centre in enumerate(gates):
        found, misses = _approaches(times, position, velocity, centre)
        close = misses <= distance
        if not close.any():
            raise MissedGateError(gate, f"is passed at {misses.min():.2f} m; {distance:g} m is the most that counts")
        found, costs = found[close], misses[close] ** 2
        before = np.zeros(len(found), dtype=np.intp)
        if chosen:
            before, earlier = _best_before(chosen[-1][0], chosen[-1][1], found)
            costs = costs + earlier
        if not np.isfinite(costs).any():
            raise MissedGateError(gate, f"is not passed after gate {gate - 1}, only before it")
        chosen.append((found, costs, before))
    passages, choice = np.empty(len(gates)), int(np.argmin(chosen[-1][1]))
    for gate in reversed(range(len(gates))):
        found, _, before = chosen[gate]
        passages[gate], choice = found[choice], int(before[choice])
    return passages


def _approaches(times: Floats, position: Floats, velocity: Floats, centre: Floats) -> tuple[Floats, Floats]:
    """Times [s] and distances [m] of the local closest approaches to a point, ascending in time."""
    offsets = position - centre
    distances = np.linalg.norm(offsets, axis=1)
    falls = np.append(np.inf, distances[:-1]) >= distances
    rises = np.append(distances[1:], np.inf) > distances
    rows = np.flatnonzero(falls & rises)
    offsets, velocity = offsets[rows], velocity[rows]
    least, most = times[np.maximum(rows - 1, 0)] - times[rows], times[np.minimum(rows + 1, len(times) - 1)] - times[rows]
    shifts = -(offsets * velocity).sum(axis=1) / np.maximum((velocity**2).sum(axis=1), 1e-12)  # foot of the perpendicular
    shifts = np.clip(shifts, least, most)
    return times[rows] + shifts, np.linalg.norm(offsets + shifts[:, None] * velocity, axis=1)


def _best_before(times: Floats, costs: Floats, later: Floats) -> tuple[np.ndarray, Floats]:
    """For each later time the cheapest of the earlier choices, as index and cost; inf where there is none."""
    least = np.minimum.accumulate(costs)
    first = np.maximum.accumulate(np.where(costs <= least, np.arange(len(costs)), 0))
    last = np.searchsorted(times, later, side="left") - 1  # strictly before
    return first[np.maximum(last, 0)], np.where(last >= 0, least[np.maximum(last, 0)], np.inf)
