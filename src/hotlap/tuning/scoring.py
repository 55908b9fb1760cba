"""Scoring: completion and cost of recorded flights under a rule; nothing is flown (Sec. IV-B of the paper)."""

from __future__ import annotations

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from hotlap.core.records import Flights, Scores
from hotlap.race.race import GateRule, JudgeSettings

TINY = 1e-6  # m, least distance of which a logarithm is taken
FAR = 1e3  # m: what a position that is no number, or further away, counts as
UNREACHED, STEEPNESS = 50.0, 8  # m, and exponent of the dense cost
PENALTY_SPEED = 1.0  # m/s at which missing metres become seconds, as in the paper


class Metric(StrEnum):
    """What the cost of a flight measures.

    TIME: [s] to pass all gates; the paper's m.
    MEAN_ERROR: [m] mean distance from the reference.
    Both carry the same penalty for the gates that were not passed.
    """

    TIME = "time"
    MEAN_ERROR = "mean_error"


def score(flights: Flights, judge: JudgeSettings, metric: Metric = Metric.TIME) -> Scores:
    """Completion, cost and failed segment of each flight of a batch.

    Differs from the released code: its penalty has no path from the drone to the first missed gate; the rule `released`
    does the same.

    Args:
        flights: what was flown, judged by the world under the same settings.
        judge: the rule that counts.
        metric: what the cost measures.
    """
    count = len(flights.gate_positions)
    complete = flights.gates_passed >= count
    lapped = complete & np.isfinite(flights.lap_time)
    time = np.where(lapped, flights.lap_time, flights.end_time)
    achieved = time if metric is Metric.TIME else flights.mean_error
    missed = np.minimum(flights.gates_passed, count - 1)
    distance, enough = _distance(flights, judge)
    return Scores(
        cost=achieved + remaining_path(flights, judge.rule) / PENALTY_SPEED,  # m(w), Sec. IV-B
        completion=flights.gates_passed / count,  # TC, Eq. 6
        failed_segment=np.where(complete, -1, flights.gate_segments[missed]),
        gate_distance=distance,
        gate_miss=np.log(np.maximum(distance, TINY) / enough),
        gate_segment=np.tile(flights.gate_segments, (len(flights), 1)),
        mean_error=flights.mean_error,
        max_error=flights.max_error,
        lap_time=np.where(lapped, flights.lap_time, np.nan),
        dense=dense_cost(distance, enough),
    )


def _distance(flights: Flights, judge: JudgeSettings) -> tuple[NDArray[np.float64], float | NDArray[np.float64]]:
    """D, distance from every gate as the rule measures it, shape (B, M) [m], and d, the one that is close enough.

    Under the rule "opening" D is 0 in the middle of an opening and grows to d, the room for the vehicle's centre, at its rim.
    """
    if judge.rule is GateRule.OPENING:
        return np.maximum(flights.rooms + flights.rim_distance, 0.0), flights.rooms
    return flights.clock_distance if judge.rule is GateRule.CLOCK else flights.closest_distance, judge.distance


def dense_cost(gate_distance: NDArray[np.float64], distance: float | NDArray[np.float64]) -> NDArray[np.float64]:
    """sum over gates of log(1 + (D_i / d)^8): near 0 well inside every gate, log 2 at D = d, then growing as 8 log D, shape (B,).

    Nearly a count of misses, but smooth. It is most informative when the flight goes on after a miss (`judge.fly_on`).

    Args:
        gate_distance: shape (B, M) [m] as the rule measures it; NaN, where a flight did not get there, counts as `UNREACHED`.
        distance: [m] d of the judge, or of each gate, shape (M,).
    """
    ratio = np.minimum(np.nan_to_num(gate_distance, nan=UNREACHED, posinf=UNREACHED), UNREACHED) / distance
    return np.log1p(ratio**STEEPNESS).sum(axis=1)


def remaining_path(flights: Flights, rule: GateRule) -> NDArray[np.float64]:
    """Shortest path from where each flight ended through the gates that it did not pass, shape (B,) [m]; 0 if there are none.

    Under the rule `released` it begins at the first missed gate.
    """
    gates = flights.gate_positions
    legs = np.linalg.norm(np.diff(gates, axis=0), axis=1)
    behind = np.append(np.cumsum(legs[::-1])[::-1], [0.0, 0.0])  # from gate i through all later ones; nothing is left at i = M
    missed = np.minimum(flights.gates_passed, len(gates) - 1)
    position = np.nan_to_num(flights.end_position, nan=FAR, posinf=FAR, neginf=-FAR)
    approach = np.minimum(np.linalg.norm(position - gates[missed], axis=1), FAR)
    if rule is GateRule.RELEASED:
        approach = np.zeros_like(approach)
    return np.where(flights.gates_passed < len(gates), approach + behind[missed], 0.0)
