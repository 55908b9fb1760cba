import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hotlap.core.parameters import reflect
from hotlap.race.controllers import space_of
from hotlap.race.race import ControllerSettings

SETTINGS = ControllerSettings()
SPACE = space_of(SETTINGS.kind, SETTINGS.low, SETTINGS.high, SETTINGS.default)

unit_rows = arrays(float, (3, SPACE.size), elements=st.floats(0, 1))
anything = arrays(float, (3, SPACE.size), elements=st.floats(-1e5, 1e5))


@given(anything)
def test_reflection_stays_inside_and_is_idempotent(values):
    once = SPACE.reflect(values)
    assert SPACE.contains(once)
    assert SPACE.reflect(once) == pytest.approx(once, rel=1e-12)


@given(unit_rows)
def test_reflection_is_a_mirror_at_each_bound(share):
    width = SPACE.high - SPACE.low
    step = share * width
    assert SPACE.reflect(SPACE.low - step) == pytest.approx(SPACE.low + step)
    assert SPACE.reflect(SPACE.high + step) == pytest.approx(SPACE.high - step)


@given(unit_rows)
def test_unit_coordinates_go_there_and_back(unit):
    values = SPACE.from_unit(unit)
    assert SPACE.contains(values)
    assert SPACE.to_unit(values) == pytest.approx(unit, abs=1e-9)


def test_the_bounds_are_zero_and_one():
    assert SPACE.to_unit(SPACE.low) == pytest.approx(np.zeros(SPACE.size))
    assert SPACE.to_unit(SPACE.high) == pytest.approx(np.ones(SPACE.size))


@given(anything)
def test_logarithms_are_reflected_in_log_space(values):
    logarithms = SPACE.reflect_log(values / 1e4)
    assert np.all(logarithms >= np.log(SPACE.low) - 1e-12)
    assert np.all(logarithms <= np.log(SPACE.high) + 1e-12)


def test_the_first_guess_is_the_default_in_every_segment():
    guess = SPACE.first_guess(4)
    assert guess.shape == (4, SPACE.size)
    assert np.array_equal(guess, [SETTINGS.default] * 4)


@given(anything)
def test_clipping_changes_only_what_lies_outside(values):
    clipped = SPACE.clip(values)
    inside = (values >= SPACE.low) & (values <= SPACE.high)
    assert SPACE.contains(clipped)
    assert np.array_equal(clipped[inside], values[inside])


def test_a_value_beyond_two_widths_is_still_folded_in():
    assert reflect(np.array([7.3]), np.array([0.0]), np.array([1.0])) == pytest.approx([0.7])
