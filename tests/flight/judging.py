"""Flights along given paths, judged period by period."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hotlap.core.records import Cause, End
from hotlap.flight.judge import Gates, Verdicts, gates_of, judge, new_verdicts
from hotlap.flight.lending import lend
from hotlap.race.race import GateRule, JudgeSettings
from hotlap.race.track import Track
from hotlap.reference.reference import PERIOD, Reference

from .kept import kept

Path = Callable[[float], Any]


@kept
def judge_one(v: Verdicts, g: Gates, start: float, before: Any, time: float, now: Any, reference: Any, rate: float) -> bool:
    """Judge a period of flight 1."""
    return judge(v, 1, lend(g), start, before, time, now, reference, rate)


def reference_of(path: Path, times: Any, last: float) -> Reference:
    """A reference of which the judge reads places and times alone."""
    position = np.array([path(t) for t in np.arange(0.0, last, PERIOD)], dtype=np.float64)
    zeros, row, four = np.zeros_like(position), np.zeros(len(position)), np.zeros((len(position), 4))
    return Reference(position, four, zeros, zeros, row, four, np.array(times, dtype=np.float64), float(times[-1]))


def place(path: Path, time: float) -> tuple[float, float, float]:
    x, y, z = path(time)
    return float(x), float(y), float(z)


def fly_track(
    track: Track, times: Any, path: Path, planned: Path | None = None, *, radius: float = 0.0, period: float = 0.01, last: float = 6.0,
    rule: GateRule = GateRule.OPENING, **settings: Any,
) -> Verdicts:  # fmt: skip
    """Judge a flight along a path where another was planned, which passes the gates at given times, until it is over."""
    reference = reference_of(planned or path, times, last + 2.0)
    g, v = gates_of(JudgeSettings(rule=rule, **settings), track, radius, reference), new_verdicts(2, len(times))
    for k in range(round(last / period)):
        start, now = period * k, period * (k + 1)
        expected = reference.position_at(np.array([now]))[0].tolist()
        if judge_one(v, g, start, place(path, start), now, place(path, now), tuple(expected), 0.0):
            return v
    return v


def outcome(v: Verdicts) -> tuple[int, End | None]:
    return int(v.gates_passed[1]), None if v.end[1] < 0 else End(v.end[1])


def crash(v: Verdicts) -> tuple[Cause, int]:
    return Cause(v.cause[1]), int(v.cause_index[1])
