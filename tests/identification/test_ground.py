"""Time on the ground is no flight: it is found, left out, and said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hotlap.core.errors import InputError
from hotlap.identification.evidence import SETTLING, lay_out
from hotlap.identification.ground import ground
from hotlap.logs.flight_log import FlightLog, Signal
from hotlap.logs.window import cut
from identification.flights import drawn
from identification.standing import standing

SECONDS = 30.0


@pytest.fixture(scope="module")
def flown():
    """Half a minute with doublets and thrust steps, by velocities and by an accelerometer."""
    log = drawn(7).fly(8, accelerometer=True, seconds=SECONDS)
    thrust = log.signals["thrust_command"]
    force = {name: one for name, one in log.signals.items() if name != "velocity"}
    speed = {name: one for name, one in log.signals.items() if name != "acceleration"}
    alone = {name: one for name, one in log.signals.items() if name in {"rates", "rate_command", "thrust_command"}}
    motors = {name: one for name, one in force.items() if name != "thrust_command"}
    motors["motor_command"] = Signal(thrust.times, np.tile(thrust.values, (1, 4)))
    return {name: replace(log, signals=one) for name, one in (("force", force), ("speed", speed), ("alone", alone), ("motors", motors))}


def found(log: FlightLog):
    return ground(log.signals, log.start, log.start + log.duration)


@pytest.mark.parametrize("by", ["force", "speed", "alone", "motors"])
def test_there_is_no_ground_in_flight(flown, by):
    assert len(found(flown[by])) == 0


@pytest.mark.parametrize("by", ["force", "speed", "alone"])
@pytest.mark.parametrize("idle", [0.0, 0.05])
def test_ground_before_and_after_a_flight_is_left_out_to_the_bin_and_the_ramp(flown, by, idle):
    log = standing(flown[by], before=10.0, after=4.0, idle=idle)
    first, last = found(log)
    assert first == pytest.approx([0.0, 10.0], abs=0.35)
    assert last == pytest.approx([10.0 + SECONDS, 14.0 + SECONDS], abs=0.35)
    evidence = lay_out(log)
    whole = lay_out(flown[by])
    for name, signal in (("rates", evidence.rates), ("force", evidence.force), ("velocity", evidence.velocity)):
        if signal is not None:
            times = signal.times[evidence.counts[name]]
            assert times[0] >= 10.0 + SETTLING - 0.35
            assert times[-1] <= 10.0 + SECONDS + 0.35
    assert evidence.seconds == pytest.approx(whole.seconds, abs=0.7)
    (note,) = evidence.notes
    assert note.startswith("rehearsal: ")
    assert "s on the ground were left out (0.0 to " in note


def test_a_landing_in_between_does_not_count(flown):
    times = flown["force"].signals["rates"].times
    half = SECONDS / 2
    begin, end = (replace(flown["force"], signals=part) for part in split(flown["force"], half))
    first, second = standing(begin, after=6.0), standing(end, before=0.0)
    joined = {}
    for name, one in first.signals.items():
        other = second.signals[name]
        joined[name] = Signal(np.concatenate([one.times, half + 6.0 + other.times]), np.vstack([one.values, other.values]))
    evidence = lay_out(replace(flown["force"], signals=joined))
    assert evidence.ground[0] == pytest.approx([half, half + 6.0], abs=0.35)
    assert evidence.seconds == pytest.approx(SECONDS, abs=0.7)
    counted = evidence.rates.times[evidence.counts["rates"]]
    assert not ((counted > half + 0.2) & (counted < half + 6.0)).any()
    assert len(counted) > 0.9 * len(times)


def split(log: FlightLog, at: float):
    """Signals before and after a time, each from 0 on."""
    before, after = {}, {}
    for name, one in log.signals.items():
        k = int(np.searchsorted(one.times, at))
        before[name] = Signal(one.times[:k], one.values[:k])
        after[name] = Signal(one.times[k:] - one.times[k], one.values[k:])
    return before, after


def test_who_only_stands_is_told_so(flown):
    rest = {name: Signal(one.times[:900], 0 * one.values[:900]) for name, one in flown["alone"].signals.items()}
    with pytest.raises(InputError, match=r"0\.0 s with commands and rates, and \d+\.\d s on the ground; at least 5 s are needed"):
        lay_out(replace(flown["alone"], signals=rest))


@pytest.mark.parametrize(
    ("window", "expected", "seconds"),
    [((5.0, None), (5.0, 29.99), 24.99), ((None, 12.0), (0.0, 12.0), 12.0), ((5.0, 12.0), (5.0, 12.0), 7.0), (None, (0.0, 29.99), 29.99)],
)
def test_a_window_cuts_every_signal_and_says_so(flown, window, expected, seconds):
    log = cut(flown["force"], window)
    for signal in log.signals.values():
        assert (signal.times[0], signal.times[-1]) == pytest.approx(expected, abs=0.011)
    assert log.duration == pytest.approx(seconds, abs=0.011)
    assert (log.notes == flown["force"].notes) is (window is None)


@pytest.mark.parametrize(
    ("window", "message"),
    [
        ((40.0, None), "from: leaves nothing of rehearsal, which is from 0.00 to 29.99 s"),
        ((None, -1.0), "to: leaves nothing of rehearsal"),
        ((3.0, 2.0), "to: is 2 s, which is not after 3 s"),
        (("soon", None), "from: must be a number of seconds, not 'soon'"),
        ((1.0,), r"window: must be \(from, to\)"),
    ],
)
def test_a_window_that_is_none_is_one_line(flown, window, message):
    with pytest.raises(InputError, match=message):
        cut(flown["force"], window)
