"""Endings: how a flight ended, in words."""

from __future__ import annotations

from hotlap.core.records import Cause, End
from hotlap.race.race import JudgeSettings, Race
from hotlap.race.track import Track


def in_words(race: Race, end: End, gates_passed: int, cause: Cause = Cause.NONE, index: int = -1) -> str:
    """How a flight ended: "missed gate 3", "hit the floor before gate 1", "touched the frame of gate 3".

    Args:
        race: that was flown.
        end: how it ended.
        gates_passed: in a row from the first.
        cause: why it crashed; NONE where that is not known.
        index: of what was touched, in the track; -1 where nothing was.
    """
    gates = [point for point in race.track.route if point.counts]
    if gates_passed >= len(gates):
        return f"all {len(gates)} gates" if len(gates) > 1 else "the only gate"
    ahead = gates[gates_passed]
    if end is not End.CRASHED:
        return f"missed {ahead.name}"
    before = f"before {ahead.name}"
    if cause is Cause.FRAME:
        its_own = ahead.key == f"gates[{index}]"
        return f"touched the frame of {ahead.name}" if its_own else f"touched the frame of {_name_of_gate(race.track, index)} {before}"
    if cause is Cause.LOST:
        return f"was lost {before}: the simulator failed"
    if cause in _DEEDS:
        return f"{_DEEDS[cause]} {before}"
    if cause in _OBSTACLES:
        return f"crashed into {_OBSTACLES[cause]} {index + 1} {before}"
    return f"crashed {before}{_why(cause, race.judge)}"


_DEEDS = {Cause.FLOOR: "hit the floor", Cause.CEILING: "hit the ceiling", Cause.OUTSIDE: "left the box"}
_OBSTACLES = {Cause.POLE: "pole", Cause.SPHERE: "sphere", Cause.BOX: "box"}


def _why(cause: Cause, judge: JudgeSettings) -> str:
    """What a crash without anything to hit was."""
    reasons = {
        Cause.DISTANCE: f": {judge.crash:g} m from the reference",
        Cause.RATE: f": turned faster than {judge.rate_crash:g} rad/s",
        Cause.NUMBERS: ": its state is not a number",
    }
    return reasons.get(cause, "")


def _name_of_gate(track: Track, index: int) -> str:
    """Name of a gate of the track, in any lap."""
    return next(point.name for point in track.route if point.key == f"gates[{index}]").removesuffix(" of lap 1")
