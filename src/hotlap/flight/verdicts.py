"""Verdicts: what is judged, as compiled code takes it, and the results of flights so far, which only the judge writes."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hotlap.core.records import Cause, End
from hotlap.flight.collisions import Objects, objects_of
from hotlap.flight.numbers import INLINE
from hotlap.flight.openings import NO_OPENINGS, Openings, openings_of
from hotlap.race.race import GateRule, JudgeSettings
from hotlap.race.track import Track
from hotlap.reference.reference import Reference

CLOCK, CLOSEST, OPENING, RELEASED = range(4)  # as compiled code knows the rules
_RULES = {GateRule.CLOCK: CLOCK, GateRule.CLOSEST: CLOSEST, GateRule.OPENING: OPENING, GateRule.RELEASED: RELEASED}
FINISHED, MISSED, CRASHED = int(End.FINISHED), int(End.MISSED), int(End.CRASHED)
FLYING = -1
TAKEN_OFF = 0.1  # m above the floor, from which on the floor must not be touched


class Gates(NamedTuple):
    """The gates of a race, what stands around them, and the rule by which flights are judged.

    Attributes:
        positions: (M, 3) [m] (world).
        times: (M,) [s] of the reference.
        opens, closes: (M,) [s] from and until when a passage counts, for the rule OPENING.
        rule: CLOCK, CLOSEST, OPENING or RELEASED.
        distance, crash, before, after, rate_crash, fly_on: as in `JudgeSettings`; the window is endless for RELEASED.
        floor: [m] height below which a drone has crashed that has taken off.
        floor_cause: what that floor is, a `Cause`: the floor, or the bottom of the track's box.
        ceiling: [m] height above which it has.
        low, high: (3,) [m] (world) beyond which it has.
        openings: of the gates, for the rule OPENING.
        objects: what must not be touched.
    """

    positions: Any
    times: Any
    opens: Any
    closes: Any
    rule: int
    distance: float
    crash: float
    before: float
    after: float
    rate_crash: float
    fly_on: bool
    floor: float
    floor_cause: int
    ceiling: float
    low: Any
    high: Any
    openings: Openings
    objects: Objects


class Verdicts(NamedTuple):
    """Results of B flights over M gates so far; only the judge writes them, one row a flight. Names as in `Flights`.

    Attributes:
        clocked: (B,) gates whose reference time has come.
        opened: (B,) first gate whose window is still open.
        ticks: (B,) control periods flown.
        airborne: (B,) whether the drone has taken off.
        free: (B,) [m] that it may fly before anything can be touched.
        entered: (B, M) the way in which it has entered the tunnel of a gate, 1 or -1; 0 outside.
        worst: (B, M) [m] largest signed distance from the tunnel's walls since then.
    """

    gates_passed: Any
    end: Any
    cause: Any
    cause_index: Any
    end_time: Any
    end_position: Any
    lap_time: Any
    clock_distance: Any
    closest_distance: Any
    closest_time: Any
    rim_distance: Any
    mean_error: Any
    max_error: Any
    clocked: Any
    opened: Any
    ticks: Any
    airborne: Any
    free: Any
    entered: Any
    worst: Any


def gates_of(judge: JudgeSettings, track: Track, radius: float, reference: Reference) -> Gates:
    """The gates and the rule of a race, as compiled code takes them.

    Args:
        judge: how it is judged.
        track: that is flown.
        radius: [m] of the vehicle.
        reference: that is followed.

    Raises:
        HotlapError: under the rule "opening", an opening is too small for the vehicle.
    """
    times = np.ascontiguousarray(reference.gate_times, dtype=np.float64)
    before, after = judge.window if judge.rule is not GateRule.RELEASED else (math.inf, math.inf)
    windows = np.stack([times - before, times + after], axis=1)
    openings = NO_OPENINGS
    if judge.rule is GateRule.OPENING:
        openings, windows = openings_of(track, judge, radius, reference)
    floor, box = -math.inf if track.floor is None else track.floor, track.box
    bottom = -math.inf if box is None else box.low[2]
    return Gates(
        positions=np.ascontiguousarray(track.gate_positions, dtype=np.float64),
        times=times,
        opens=np.ascontiguousarray(windows[:, 0]),
        closes=np.ascontiguousarray(windows[:, 1]),
        rule=_RULES[judge.rule],
        distance=float(judge.distance),
        crash=float(judge.crash),
        before=float(before),
        after=float(after),
        rate_crash=float(judge.rate_crash),
        fly_on=bool(judge.fly_on),
        floor=float(max(floor, bottom)),
        floor_cause=int(Cause.FLOOR if floor >= bottom else Cause.OUTSIDE),
        ceiling=math.inf if track.ceiling is None else float(track.ceiling - radius),
        low=np.full(3, -math.inf) if box is None else np.array([box.low[0] + radius, box.low[1] + radius, -math.inf]),
        high=np.full(3, math.inf) if box is None else np.array(box.high) - radius,
        openings=openings,
        objects=objects_of(track, radius),
    )


def new_verdicts(flights: int, gates: int) -> Verdicts:
    """The results of flights that have not begun."""

    def rows(*shape: int, value: float = math.nan) -> NDArray[np.float64]:
        """Real numbers of each flight."""
        return np.full((flights, *shape), value)

    def counts(*shape: int, value: int = 0) -> NDArray[np.int64]:
        """Whole numbers of each flight."""
        return np.full((flights, *shape), value, dtype=np.int64)

    return Verdicts(
        gates_passed=counts(),
        end=counts(value=FLYING),
        cause=counts(),
        cause_index=counts(value=-1),
        end_time=rows(),
        end_position=rows(3),
        lap_time=rows(),
        clock_distance=rows(gates),
        closest_distance=rows(gates),
        closest_time=rows(gates),
        rim_distance=rows(gates),
        mean_error=rows(value=0.0),
        max_error=rows(value=0.0),
        clocked=counts(),
        opened=counts(),
        ticks=counts(),
        airborne=counts(),
        free=rows(value=0.0),
        entered=counts(gates),
        worst=rows(gates),
    )


@njit(**INLINE)
def end_flight(v: Verdicts, i: int, how: int, time: float, position: Any) -> None:
    """Record how a flight ended; only the first end counts."""
    if v.end[i] == FLYING:
        v.end[i] = how
        v.end_time[i] = time
        for k in range(3):
            v.end_position[i, k] = position[k]


@njit(**INLINE)
def finish(v: Verdicts, i: int, lap_time: float, now: Any) -> bool:
    """End a flight that has passed every gate."""
    if v.end[i] == FLYING:
        v.lap_time[i] = lap_time
    end_flight(v, i, FINISHED, lap_time, now)
    return True


@njit(**INLINE)
def approach(
    v: Verdicts, i: int, g: Gates, k: int, length: float, earliest: float, latest: float, start: float, before: Any, time: float, now: Any
) -> bool:
    """Measure the closest approach to gate k within a part of a period, to the straight line, of which length is the square of its length.

    Returns:
        Whether there is such a part.
    """
    if earliest > latest:
        return False
    along = 0.0
    for j in range(3):
        along += (g.positions[k, j] - before[j]) * (now[j] - before[j])
    share = along / length if length > 0 else 0.0
    share = min(max(share, (earliest - start) / (time - start)), (latest - start) / (time - start))
    square = 0.0
    for j in range(3):
        square += (before[j] + share * (now[j] - before[j]) - g.positions[k, j]) ** 2
    if not v.closest_distance[i, k] ** 2 <= square:  # also where there is none yet
        v.closest_distance[i, k] = math.sqrt(square)
        v.closest_time[i, k] = start + share * (time - start)
    return True
