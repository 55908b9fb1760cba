"""Offsets lead from the first guess to the bounds and no further."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.race.controllers import TUNABLE, ControllerKind, space_of
from hotlap.tuners.offsets import Offsets

TUNED = TUNABLE[ControllerKind.MPC]
SPACE = space_of(ControllerKind.MPC, TUNED.low, TUNED.high, TUNED.default)
FIRST = SPACE.first_guess(3) * np.array([[1.0], [0.8], [1.2]])


@pytest.mark.parametrize("tied", [True, False])
def test_no_offset_is_the_first_guess(tied):
    offsets = Offsets(SPACE, FIRST, tied)
    assert_array_equal(offsets.decode(np.zeros((1, 5 if tied else 15)))[0], SPACE.clip(FIRST))


@pytest.mark.parametrize("tied", [True, False])
def test_bounds_reach_those_of_the_space_in_every_segment(tied):
    offsets = Offsets(SPACE, FIRST, tied)
    low, high = offsets.decode(np.array(offsets.bounds))
    assert_allclose(low, np.tile(SPACE.low, (3, 1)), rtol=1e-12)
    assert_allclose(high, np.tile(SPACE.high, (3, 1)), rtol=1e-12)


def test_an_offset_is_a_factor_in_every_segment_and_half_of_it_for_the_horizon():
    moved = Offsets(SPACE, FIRST, tied=True).decode(np.full((1, 5), 0.1))[0]
    assert_allclose(moved / FIRST, np.tile(np.exp(0.1 * SPACE.log_step), (3, 1)))
    assert SPACE.log_step[4] == 0.5
