"""The throttle for a thrust: the inverse of what a motor gives, corrected by hovering and by the battery."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hotlap.core.errors import HotlapError
from hotlap.real_flight.thrust_map import ThrustMap

FULL = 30.0
SHARES = st.floats(0.0, 1.0)


@given(thrust=st.floats(0.0, FULL), curve=st.one_of(SHARES, st.floats(0.0, 1e-6)))
def test_it_is_the_inverse_of_the_curve(thrust, curve):
    u = ThrustMap(FULL, curve).throttle(thrust)
    assert 0 <= u <= 1
    assert FULL * (curve * u * u + (1 - curve) * u) == pytest.approx(thrust, abs=1e-12)


@pytest.mark.parametrize("thrust", [-1.0, 0.0, float("nan"), 1e9, float("inf")])
def test_no_thrust_takes_it_out_of_its_range(thrust):
    assert 0 <= ThrustMap(FULL).throttle(thrust) <= 1


@given(share=st.floats(0.55, 1.9), curve=SHARES)
def test_hovering_finds_the_throttle_that_carries_the_weight(share, curve):
    known = ThrustMap(FULL, curve)
    known.correct(share)
    u = known.throttle(9.81)
    assert share * FULL * (curve * u * u + (1 - curve) * u) == pytest.approx(9.81, rel=1e-6)
    assert known.hover_throttle == u


def test_corrections_add_up_and_end_where_the_file_is_of_another_drone():
    known = ThrustMap(FULL)
    known.correct(0.8)
    known.correct(0.75)
    assert known.gain == pytest.approx(0.6)
    with pytest.raises(HotlapError, match=r"hovering takes 3\.33 times the throttle .* is it the file of this drone"):
        known.correct(0.5)
    assert known.gain == pytest.approx(0.6)
    with pytest.raises(HotlapError):
        ThrustMap(FULL).correct(float("nan"))


def test_a_lower_voltage_takes_more_throttle_by_its_square_and_slowly():
    known = ThrustMap(FULL)
    known.hear(0.0, 16.0)
    before = known.throttle(10.0)
    known.hear(0.01, 15.0)
    assert known.throttle(10.0) == pytest.approx(before, rel=0.01)
    known.hear(10.0, 15.0)
    assert known.throttle(10.0) == pytest.approx(before * (16 / 15) ** 2)


@given(voltages=st.lists(st.one_of(st.floats(-1.0, 11.9), st.floats(19.3, 1e9), st.just(float("nan"))), max_size=5))
def test_a_sensor_that_fails_changes_no_thrust(voltages):
    known = ThrustMap(FULL)
    known.hear(0.0, 16.0)
    known.hear(10.0, 15.0)
    before = known.throttle(10.0)
    for step, voltage in enumerate(voltages):
        known.hear(11.0 + step, voltage)
    assert known.throttle(10.0) == before


def test_who_makes_up_for_the_battery_is_believed_and_no_voltage_is_none():
    known, deaf = ThrustMap(FULL, with_battery=False), ThrustMap(FULL)
    for voltage in (16.0, 15.0):
        known.hear(voltage, voltage)
    for voltage in (float("nan"), 0.0, -1.0):
        deaf.hear(0.0, voltage)
    assert known.throttle(10.0) == deaf.throttle(10.0) == pytest.approx(1 / 3)
