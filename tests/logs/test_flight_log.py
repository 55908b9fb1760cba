"""A log answers between its samples, and says nothing beyond them."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.logs.flight_log import FlightLog, Signal


@pytest.fixture
def signal():
    times = np.array([1.0, 2.0, 4.0])
    return Signal(times, np.column_stack([times, -3.0 * times]))


def test_a_signal_is_linear_between_samples_and_unknown_beyond(signal):
    found = signal.at(np.array([0.9, 1.0, 1.5, 3.0, 4.0, 4.1]))
    assert np.isnan(found[[0, -1]]).all()
    np.testing.assert_allclose(found[1:-1], [[1.0, -3.0], [1.5, -4.5], [3.0, -9.0], [4.0, -12.0]])


def test_a_step_is_the_usual_one_and_a_gap_is_longer():
    times = np.concatenate([np.arange(0.0, 1.0, 0.01), np.arange(2.0, 3.0, 0.01)])
    signal = Signal(times, np.zeros((200, 1)))
    assert signal.step == pytest.approx(0.01)
    np.testing.assert_allclose(signal.gaps(), [[0.99, 2.0]])
    assert Signal(times[:1], np.zeros((1, 1))).gaps().shape == (0, 2)


def test_a_rate_is_of_the_whole_signal(signal):
    assert signal.rate == pytest.approx(2 / 3)
    assert Signal(np.array([1.0]), np.ones((1, 3))).rate == 0.0


def test_a_log_is_as_long_as_all_its_signals(signal):
    other = Signal(signal.times + 2.5, signal.values)
    log = FlightLog("mine.csv", "a spreadsheet", {"position": signal, "rates": other})
    assert (log.start, log.duration) == (1.0, 5.5)
    assert FlightLog("none.csv", "a spreadsheet", {}).duration == 0.0
