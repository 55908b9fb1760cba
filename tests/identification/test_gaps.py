"""Whatever a prediction is made of, nothing counts where it is missing, and a fit is as good without as with the hole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hotlap.core.errors import InputError
from hotlap.identification.evidence import SETTLING, lay_out, stretches
from hotlap.identification.identify import identify
from hotlap.logs.flight_log import Signal
from identification.flights import BASE, drawn, errors

BEGIN, END = 5.0, 7.0


@pytest.fixture(scope="module")
def truth():
    return drawn(3)


@pytest.fixture(scope="module")
def flown(truth):
    return truth.fly(3, seconds=12.0)


@pytest.fixture(scope="module")
def forced(truth):
    return truth.fly(3, seconds=12.0, accelerometer=True)


def holed(log, name):
    signal = log.signals[name]
    kept = (signal.times < BEGIN) | (signal.times > END)
    return replace(log, signals={**log.signals, name: Signal(signal.times[kept], signal.values[kept])})


def hidden(signal, counts) -> bool:
    """Whether nothing in the hole counts, and everything else but the settling."""
    inside = (signal.times > BEGIN) & (signal.times < END + SETTLING - 0.02)
    outside = (signal.times < BEGIN - 0.02) & (signal.times > SETTLING) | (signal.times > END + SETTLING + 0.02)
    return not counts[inside].any() and bool(counts[outside].all())


def whole(signal, counts) -> bool:
    return bool(counts[signal.times > SETTLING].all())


@pytest.mark.parametrize(
    ("name", "of_rates"),
    [("rates", True), ("rate_command", True), ("thrust_command", True), ("velocity", False), ("attitude", False)],
)
def test_a_hole_does_not_count(flown, forced, name, of_rates):
    evidence = lay_out(holed(flown, name))
    assert evidence.velocity is not None
    assert (hidden if of_rates else whole)(evidence.rates, evidence.counts["rates"])
    if name != "rates":
        assert hidden(evidence.velocity, evidence.counts["velocity"])
        evidence = lay_out(holed(forced, name))
        assert evidence.force is not None
        assert hidden(evidence.force, evidence.counts["force"])


def test_what_ends_early_does_not_count_from_there_on(forced):
    attitude = forced.signals["attitude"]
    short = Signal(attitude.times[:800], attitude.values[:800])
    evidence = lay_out(replace(forced, signals={**forced.signals, "attitude": short}))
    assert evidence.force is not None
    assert not evidence.counts["force"][evidence.force.times > 8.0].any()
    assert whole(evidence.rates, evidence.counts["rates"])


def emptied(log, name, begin, end):
    signal = log.signals[name]
    kept = (signal.times < begin) | (signal.times > end)
    return replace(log, signals={**log.signals, name: Signal(signal.times[kept], signal.values[kept])})


def test_what_hardly_counts_is_left_out(flown):
    evidence = lay_out(emptied(flown, "velocity", 2.0, 11.0))
    assert evidence.output is None
    assert evidence.notes[-1].startswith("rehearsal: velocity: ")
    assert "s without gaps are too few: it was left out" in evidence.notes[-1]


def test_commands_that_are_hardly_there_are_told_in_one_line(flown):
    with pytest.raises(InputError, match=r"rehearsal: \d\.\d s with commands and rates, without gaps; at least 4 s are needed"):
        lay_out(emptied(flown, "rate_command", 2.0, 11.0))


def test_stretches_begin_behind_gaps():
    counts = np.array([False, True, True, False, False, True, False, True])
    assert stretches(counts).tolist() == [0, 0, 0, 0, 0, 1, 1, 2]
    assert stretches(counts[1:]).tolist() == [0, 0, 0, 0, 1, 1, 2]


@pytest.mark.check
@pytest.mark.parametrize("name", ["attitude", "thrust_command"])
def test_a_hole_does_not_bend_a_fit(truth, flown, name):
    found = identify([holed(flown, name)], BASE, thrust_known=True)
    off = errors(found, truth)
    assert {key: off[key] for key in ("mass", "dead time", "rate gain roll", "rate gain pitch") if off[key] > 0.05} == {}
