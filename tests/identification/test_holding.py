"""What intervals leave open, as conditions that can be asked for."""

from __future__ import annotations

import math

import pytest

from hotlap.identification.estimates import Estimate
from hotlap.identification.holding import hold_of
from hotlap.race.hold import parse_hold


def an_estimate(name: str, value: float, low: float, high: float, reason: str = "") -> Estimate:
    return Estimate(name, "", "", value, low, high, math.nan, reason)


def test_each_quantity_is_off_by_its_widest_interval_rounded_up():
    found = (
        an_estimate("full thrust per mass", 50.0, 49.9, 50.1),
        an_estimate("motor lag up", 0.030, 0.0288, 0.0312),
        an_estimate("motor lag down", 0.040, 0.0396, 0.0404),
        an_estimate("rate gain roll", 20.0, 19.0, 20.5),
        an_estimate("dead time", 0.040, 0.0385, 0.0412),
        an_estimate("drag x", 0.3, 0.27, 0.33),
        an_estimate("drag z", 0.01, -0.05, 0.07),
    )
    assert hold_of(found) == "thrust=+-1%, motor=+-4%, rate_gain=+-5%, drag=+-10%, delay=+-2ms"


def test_what_is_asked_for_can_be_flown():
    names = ("full thrust per mass", "motor lag up", "rate gain yaw", "dead time", "drag x")
    found = [an_estimate(name, 0.04, 0.0391, 0.041) for name in names]
    assert len(parse_hold(hold_of(found))) == 10


@pytest.mark.parametrize(("value", "hold"), [(0.0006, "delay=+2ms"), (0.002, "delay=+-2ms")])
def test_no_dead_time_gets_less_than_none(value, hold):
    assert hold_of([an_estimate("dead time", value, value - 0.001, value + 0.002)]) == hold


def test_what_a_log_does_not_tell_is_not_asked_for():
    assert hold_of([an_estimate("dead time", 0.04, 0.0, 0.08, "too wide"), an_estimate("drag x", 0.3, 0.0, 0.6)]) == ""
