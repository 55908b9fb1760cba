"""The judge reads straight lines between the ends of control periods, by the rule of the race."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.core.records import Cause, End
from hotlap.flight.judge import Verdicts, gates_of, new_verdicts
from hotlap.race.race import GateRule, JudgeSettings
from hotlap.race.track import Gate, Track

from .judging import crash, judge_one, outcome, place, reference_of

GATES = np.array([[2.0, 0, 0], [4.0, 0, 0], [6.0, 0, 0]])
TIMES = np.array([1.0, 2.0, 3.0])  # the reference flies at 2 m/s along x
SPEED = 2.0
EVERY_RULE = pytest.mark.parametrize("rule", GateRule)


def fly(
    path: Any, settings: JudgeSettings | None = None, *, period: float = 0.1, last: float = 6.0, rates: Any = lambda t: 0.0,
    floor: float | None = None, times: np.ndarray = TIMES, gates: np.ndarray = GATES,
) -> Verdicts:  # fmt: skip
    """Judge a flight along path(t), which is (x, y, z), period by period until it is over."""
    track = Track(name="line", start=(0.0, 0.0, 0.0), gates=tuple(Gate(position=tuple(gate)) for gate in gates.tolist()), floor=floor)
    g, v = gates_of(settings or JudgeSettings(), track, 0.0, reference_of(beside(0.0), times, last)), new_verdicts(2, len(gates))
    for k in range(round(last / period)):
        start, now = period * k, period * (k + 1)
        reference = (SPEED * now, 0.0, 0.0)
        if judge_one(v, g, start, place(path, start), now, place(path, now), reference, float(rates(now))):
            return v
    return v


def beside(offset: float, late: float = 0.0) -> Any:
    """Along the reference, to the left of it and late."""
    return lambda t: (SPEED * (t - late), offset, 0.0)


def settings(rule: GateRule = GateRule.CLOCK, **others: Any) -> JudgeSettings:
    return JudgeSettings(rule=rule, **others)


@EVERY_RULE
def test_a_flight_on_the_reference_finishes(rule):
    v = fly(beside(0.0), settings(rule))
    assert outcome(v) == (3, End.FINISHED)
    assert v.lap_time[1] == v.end_time[1] == pytest.approx(3.0)
    assert_allclose(v.end_position[1], GATES[2], atol=0.3)
    assert_allclose(v.closest_distance[1], 0.0, atol=1e-9)
    assert v.max_error[1] == pytest.approx(0.0, abs=1e-9)


@EVERY_RULE
def test_only_the_flight_at_hand_is_written(rule):
    v, fresh = fly(beside(0.5), settings(rule)), new_verdicts(2, 3)
    for mine, other in zip(v, fresh, strict=True):
        assert_array_equal(mine[0], other[0])


@pytest.mark.parametrize(("offset", "passed"), [(1.29, 3), (1.31, 0)])
def test_the_clock_wants_the_drone_close_at_the_references_time(offset, passed):
    v = fly(beside(offset))
    assert outcome(v) == (passed, End.FINISHED if passed else End.MISSED)
    assert v.clock_distance[1, 0] == pytest.approx(offset)


def test_the_clock_does_not_care_how_close_it_comes_later():
    v = fly(beside(0.0, late=0.7))  # 1.4 m behind
    assert outcome(v) == (0, End.MISSED)
    assert v.end_time[1] == pytest.approx(1.0)
    assert_allclose(v.end_position[1], [0.6, 0, 0], atol=1e-12)


def test_the_clock_falls_between_the_ends_of_periods():
    """A zigzag: on the reference at the ends of periods of 0.4 s, a straight line in between."""
    times = np.array([1.0, 1.9, 3.1])
    v = fly(lambda t: (SPEED * t, 3.0 * (round(t / 0.4) % 2), 0.0), settings(distance=2.9), period=0.4, times=times, gates=GATES)
    assert_allclose(v.clock_distance[1], np.hypot([1.5, 2.25, 0.75], [0.0, 0.2, 0.2]), rtol=1e-9)


def test_several_gates_may_fall_into_one_period():
    times = np.array([1.01, 1.03, 1.07])
    gates = np.array([[2.02, 0, 0], [2.06, 0, 0], [2.14, 0, 0]])
    assert outcome(fly(beside(0.0), times=times, gates=gates)) == (3, End.FINISHED)
    wide = gates + [[0, 0, 0], [0, 2.0, 0], [0, 0, 0]]
    v = fly(beside(0.0), times=times, gates=wide)
    assert outcome(v) == (1, End.MISSED)
    assert v.end_time[1] == pytest.approx(1.03)
    assert_allclose(v.end_position[1], [2.06, 0, 0], atol=1e-12)


def test_after_a_miss_it_may_fly_on():
    def path(t: float) -> tuple[float, float, float]:
        return SPEED * t, 2.0 * (1.5 < t < 2.5), 0.0

    stopped, flown = fly(path), fly(path, settings(fly_on=True))
    assert outcome(stopped) == outcome(flown) == (1, End.MISSED)
    assert stopped.end_time[1] == flown.end_time[1] == pytest.approx(2.0)
    assert np.isnan(stopped.clock_distance[1, 2])
    assert flown.clock_distance[1, 2] == pytest.approx(0.0, abs=1e-9)
    assert np.isnan(flown.lap_time[1])
    assert flown.ticks[1] == 30
    assert stopped.ticks[1] == 20


CAUSES = {
    "away": Cause.DISTANCE, "floor": Cause.FLOOR, "nan": Cause.NUMBERS, "rate": Cause.RATE, "nan rate": Cause.NUMBERS,
}  # fmt: skip


def crash_at(time: float, how: str) -> dict[str, Any]:
    """A flight on the reference until something goes wrong."""
    wrong = {"away": (0.0, 11.0, 0.0), "floor": (0.0, 0.0, -2.0), "nan": (np.nan, 0.0, 0.0)}.get(how, (0.0, 0.0, 0.0))
    rate = {"rate": 61.0, "nan rate": np.nan}.get(how, 0.0)
    return {
        "path": lambda t: np.add((SPEED * t, 0.0, 0.0), wrong if t > time else (0, 0, 0)),
        "rates": lambda t: rate if t > time else 0.0,
        "floor": -1.0,
    }


@EVERY_RULE
@pytest.mark.parametrize("how", CAUSES)
def test_a_crash_ends_the_flight_and_has_a_cause(how, rule):
    v = fly(settings=settings(rule, distance=0.5), **crash_at(1.45, how))
    assert outcome(v) == (1, End.CRASHED)
    assert crash(v) == (CAUSES[how], -1)
    assert v.end_time[1] == pytest.approx(1.5)
    assert np.isnan(v.lap_time[1])
    assert np.isfinite([v.mean_error[1], v.max_error[1]]).all()


def test_without_a_floor_there_is_none():
    crash = crash_at(1.45, "floor")
    assert outcome(fly(crash["path"], settings(distance=3.0))) == (3, End.FINISHED)


def test_a_crash_after_a_miss_changes_nothing_but_stops():
    crash = crash_at(2.45, "away")
    v = fly(lambda t: np.add(crash["path"](t), (0, 1.4, 0)), settings(fly_on=True))
    assert outcome(v) == (0, End.MISSED)
    assert v.end_time[1] == pytest.approx(1.0)
    assert v.ticks[1] == 25


def test_a_miss_and_a_crash_in_one_period_are_a_crash():
    v = fly(**crash_at(0.95, "away"))
    assert outcome(v) == (0, End.CRASHED)


@pytest.mark.parametrize(("late", "passed"), [(0.45, 3), (0.75, 0), (-0.25, 3), (-0.35, 0)])
def test_the_closest_rule_looks_within_its_window(late, passed):
    v = fly(beside(0.0, late), settings(GateRule.CLOSEST, window=(0.3, 0.6), distance=0.05), period=0.01)
    assert outcome(v) == (passed, End.FINISHED if passed else End.MISSED)
    if passed:
        assert_allclose(v.closest_time[1], TIMES + late, atol=1e-9)
        assert v.lap_time[1] == pytest.approx(3.0 + late)


def test_edges_of_the_window_lie_between_the_ends_of_periods():
    """Nearest at the edge itself: 0.1 s before the passage at 2 m/s."""
    v = fly(beside(0.0, late=0.7), settings(GateRule.CLOSEST, window=(0.3, 0.6), distance=0.3), period=0.25)
    assert_allclose(v.closest_distance[1], 0.2, rtol=1e-9)
    assert_allclose(v.closest_time[1], TIMES + 0.6, rtol=1e-9)


def test_a_miss_by_the_closest_rule_is_known_when_the_window_closes():
    v = fly(beside(1.5), settings(GateRule.CLOSEST, window=(0.3, 0.6)))
    assert outcome(v) == (0, End.MISSED)
    assert v.end_time[1] == pytest.approx(1.6, abs=0.1001)


def test_a_lap_by_the_closest_rule_ends_at_the_closest_approach():
    """Within 1.3 m before the gate, but the lap is over when the drone recedes from it."""
    v = fly(beside(0.8, late=0.43), settings(GateRule.CLOSEST))
    assert outcome(v) == (3, End.FINISHED)
    assert v.lap_time[1] == v.end_time[1] == pytest.approx(3.43)
    assert_allclose(v.closest_distance[1], 0.8, rtol=1e-9)


def test_a_crash_behind_the_last_gate_is_none():
    v = fly(lambda t: (SPEED * t, 0.0, 0.0) if t < 2.95 else (6.0 - 12 * (t > 3.05), 0.0, 0.0), settings(GateRule.CLOSEST, crash=3.0))
    assert outcome(v) == (3, End.FINISHED)


def test_the_released_rule_looks_at_the_whole_flight_and_not_at_the_last_gate():
    early = fly(lambda t: (min(8 * t, 4.0) if t < 2.5 else 3.5, 0.0, 0.0), settings(GateRule.RELEASED))
    assert outcome(early) == (3, End.FINISHED)
    assert early.lap_time[1] == pytest.approx(3.0)
    assert_allclose(early.closest_distance[1, :2], 0.0, atol=1e-9)
    assert early.closest_distance[1, 2] == pytest.approx(2.0)


@pytest.mark.parametrize(("offset", "passed"), [(1.19, 3), (1.21, 0)])
def test_the_released_rule_wants_1_2_metres(offset, passed):
    v = fly(beside(offset), settings(GateRule.RELEASED))
    assert outcome(v) == (passed, End.FINISHED if passed else End.MISSED)
    assert v.end_time[1] == pytest.approx(3.0)


def test_errors_are_distances_from_the_reference():
    v = fly(lambda t: (SPEED * t, 0.5 * t, 0.0), settings(distance=5.0))
    distances = 0.5 * 0.1 * np.arange(1, 31)
    assert v.mean_error[1] == pytest.approx(distances.mean())
    assert v.max_error[1] == pytest.approx(distances.max())
    crashed = fly(**crash_at(1.45, "away"))
    assert crashed.max_error[1] == pytest.approx(11.0)


@EVERY_RULE
@pytest.mark.parametrize("path", [beside(0.9), beside(0.3, 0.35), beside(1.25), beside(0.0, -0.2)])
def test_finer_periods_see_the_same(rule, path):
    coarse, fine = fly(path, settings(rule), period=0.2), fly(path, settings(rule), period=0.02)
    assert outcome(coarse) == outcome(fine)
    for name in ("closest_distance", "closest_time", "lap_time", "clock_distance"):
        expected, found = getattr(fine, name)[1], getattr(coarse, name)[1]
        seen = np.isfinite(expected) & np.isfinite(found)
        assert_allclose(found[seen], expected[seen], atol=0.02 if name == "closest_distance" else 1e-9, err_msg=name)
    assert_array_equal(coarse.end_time[1], pytest.approx(fine.end_time[1], abs=0.2))


def test_a_gate_counts_once_the_one_before_it_does():
    """Flown backwards, the last gate comes first; nothing counts until the first one was passed, at x = 2.2 m."""
    backwards = settings(GateRule.CLOSEST, window=(3.0, 3.0), crash=20.0, distance=0.3)
    v = fly(lambda t: (6.0 - SPEED * t, 0.0, 0.0), backwards, last=1.85)
    assert outcome(v) == (0, None)
    v = fly(lambda t: (6.0 - SPEED * t, 0.0, 0.0), backwards)
    assert outcome(v) == (3, End.FINISHED)
    assert v.ticks[1] == 19
