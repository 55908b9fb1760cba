"""Effort tells calm commands from shaking ones."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.race.race import ControllerSettings
from hotlap.report.effort import QUICK, measure

SETTINGS = ControllerSettings()
TIMES = np.arange(500) * 0.01


def inputs(thrust=10.0, roll=0.0):
    return np.column_stack([np.full(500, thrust), np.broadcast_to(roll, 500), np.zeros((500, 2))])


def test_nothing_that_changes_is_no_effort():
    effort = measure(inputs(), 0.01, SETTINGS)
    assert vars(effort) == {"thrust_activity": 0, "rate_activity": 0, "saturated": 0, "frequency": 0, "share": 0}


@pytest.mark.parametrize("rows", [0, 1])
def test_too_short_a_flight_has_none(rows):
    assert measure(inputs()[:rows], 0.01, SETTINGS).thrust_activity == 0


def test_a_ramp_changes_as_fast_as_it_is_steep():
    effort = measure(inputs(thrust=1 + 2.0 * TIMES, roll=-3.0 * TIMES), 0.01, SETTINGS)
    assert effort.thrust_activity == pytest.approx(2.0)
    assert effort.rate_activity == pytest.approx(3.0)


@pytest.mark.parametrize(("frequency", "quick"), [(0.8, False), (8.0, True)])
def test_shaking_is_found_at_its_frequency(frequency, quick):
    effort = measure(inputs(roll=np.sin(2 * np.pi * frequency * TIMES)), 0.01, SETTINGS)
    assert (effort.share > 0.9) == quick
    assert (effort.share < 0.1) == (not quick)
    assert effort.frequency > QUICK
    if quick:
        assert effort.frequency == pytest.approx(frequency, abs=0.2)


def test_time_at_a_limit_is_counted_once_whichever_it_is():
    low, high = SETTINGS.thrust
    commands = inputs(roll=np.where(np.arange(500) < 100, -SETTINGS.rates[0], 0.0))
    commands[50:150, 0], commands[150:200, 0] = high, low
    assert measure(commands, 0.01, SETTINGS).saturated == pytest.approx(200 / 500)


def test_rows_that_are_no_numbers_are_left_out():
    commands = inputs(roll=np.sin(TIMES))
    commands[-1] = np.nan
    assert np.isfinite(list(vars(measure(commands, 0.01, SETTINGS)).values())).all()
