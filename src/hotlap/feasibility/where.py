"""Where flights fail: the gate that most of those that failed did not pass. What lies after it made none of them fail."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hotlap.core.records import End, Flights
from hotlap.race.race import Race
from hotlap.reference.reference import Reference


@dataclass(frozen=True)
class Where:
    """The place at which most of the flights that failed did.

    Attributes:
        gate: index of the first counted gate that these did not pass; the number of gates where they passed all.
        name: of that gate; "" where they passed all.
        time: [s] on the clock of the reference, until which they flew; infinite where they passed all.
        flights: shape (B,) which flights failed there.
        times: shape (B,) [s] at which each flight passed that gate, or missed it: what it did later is of no interest.
    """

    gate: int
    name: str
    time: float
    flights: NDArray[np.bool_]
    times: NDArray[np.float64]

    def top_speed(self, reference: Reference) -> float:
        """[m/s] largest of a reference until then."""
        return float(reference.speeds[: self.row(reference) + 1].max())

    def mean_speed(self, reference: Reference, last: float) -> float:
        """[m/s] mean of a reference in the last seconds before."""
        row = self.row(reference)
        return float(reference.speeds[max(row - round(last / reference.period), 0) : row + 1].mean())

    def row(self, reference: Reference) -> int:
        """The planned row of a reference that is flown then."""
        return int(min(self.time / reference.period, reference.planned_rows - 1))


def where_most_fail(race: Race, flights: Flights, failed: NDArray[np.bool_]) -> Where:
    """Where most of some flights failed; of two places the earlier one.

    Args:
        race: that was flown.
        flights: all of them.
        failed: shape (B,) which of them failed; at least one.
    """
    gate = int(np.bincount(flights.gates_passed[failed]).argmax())
    there = failed & (flights.gates_passed == gate)
    names = [point.name for point in race.track.route if point.counts]
    if gate >= len(names):
        return Where(len(names), "", math.inf, there, flights.end_time)
    passing = np.fmax(flights.closest_time[:, gate], flights.gate_times[gate])  # judged after its window alone
    crashed = there & (flights.end == End.CRASHED)
    late = float(np.median(flights.end_time[crashed])) if 2 * crashed.sum() > there.sum() else math.inf
    return Where(gate, names[gate], min(float(flights.gate_times[gate]), late), there, np.fmin(flights.end_time, passing))
