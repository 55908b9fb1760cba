"""What a log lacks in parts is left out with a note, and never ends a fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hotlap.identification.evidence import lay_out
from hotlap.identification.identify import identify
from hotlap.logs.flight_log import Signal
from identification.flights import BASE, drawn


@pytest.fixture(scope="module")
def flown():
    """Eight seconds, by velocities."""
    return drawn(3).fly(3, seconds=8.0)


@pytest.fixture(scope="module")
def forced():
    """The same by an accelerometer."""
    log = drawn(3).fly(3, seconds=8.0, accelerometer=True)
    return replace(log, signals={name: one for name, one in log.signals.items() if name != "velocity"})


def changed(log, **signals):
    return replace(log, signals={**log.signals, **signals})


def volts(log, values) -> Signal:
    times = log.signals["rates"].times
    return Signal(times, np.broadcast_to(np.asarray(values, dtype=np.float64), len(times)).copy()[:, None])


def thinned(signal: Signal, every: int, first: int = 0) -> Signal:
    return Signal(signal.times[first::every].copy(), signal.values[first::every].copy())


def test_a_battery_that_nothing_measures_is_none(flown):
    found = identify([changed(flown, battery=volts(flown, 0.0))], BASE)
    without = identify([flown], BASE)
    assert [one.value for one in found.estimates] == [one.value for one in without.estimates]
    assert np.isnan(found.thrust_map.voltage)
    assert any("battery: 800 of 800 samples are without a voltage" in note for note in found.notes)


def test_voltages_that_drop_out_are_left_out(flown):
    values = np.full(800, 15.0)
    values[::7] = 0.0
    evidence = lay_out(changed(flown, battery=volts(flown, values)))
    assert evidence.thrust_command is not None
    np.testing.assert_array_equal(evidence.thrust_command.values[:, 1], 15.0)
    assert evidence.notes == ("rehearsal: battery: 115 of 800 samples are without a voltage and were left out",)


def test_attitudes_of_length_0_are_left_out(flown):
    attitude = flown.signals["attitude"]
    lost = attitude.values.copy()
    lost[300:305] = 0.0
    evidence = lay_out(changed(flown, attitude=Signal(attitude.times, lost)))
    assert evidence.rotations is not None
    assert np.isfinite(evidence.rotations).all()
    assert any("attitude: 5 of 800 samples are of length 0 and were left out" in note for note in evidence.notes)


@pytest.mark.parametrize(
    ("name", "thin", "reason"),
    [
        ("velocity", lambda one: thinned(one, 800, 100), "0.0 s of it lie beside rates and commands"),
        ("velocity", lambda one: thinned(one, 30), "3.3 samples a second are too few"),
        ("velocity", lambda one: Signal(one.times[:300], one.values[:300]), "3.0 s of it lie beside rates and commands"),
        ("velocity", lambda one: Signal(one.times + 100, one.values), "0.0 s of it lie beside rates and commands"),
        ("attitude", lambda one: thinned(one, 800, 100), "0.0 s of it lie beside rates and commands"),
        ("thrust_command", lambda one: thinned(one, 800, 100), "0.0 s of it lie beside rates and commands"),
        ("thrust_command", lambda one: thinned(one, 50), "2 samples a second are too few"),
    ],
)
def test_a_signal_that_is_too_thin_or_apart_is_left_out(flown, name, thin, reason):
    evidence = lay_out(changed(flown, **{name: thin(flown.signals[name])}))
    assert evidence.output is None
    assert evidence.notes == (f"rehearsal: {name}: {reason}: it was left out",)


def test_a_force_that_is_sampled_once_is_none(forced):
    log = changed(forced, acceleration=thinned(forced.signals["acceleration"], 800))
    assert lay_out(log).force is None
    assert "drag" in {one.name for one in identify([log], BASE).untold}


@pytest.mark.check
def test_the_error_of_the_base_is_that_of_the_base_alone(flown):
    """A battery that does not sag changes nothing of it, whatever the fit finds of the throttle."""
    log = replace(flown, facts={})
    with_battery, without = (identify([one], BASE).predictions for one in (changed(log, battery=volts(log, 15.0)), log))
    for one, other in zip(with_battery, without, strict=True):
        assert one.former_error == pytest.approx(other.former_error, rel=1e-9)
