"""Points of the box are parameters within their bounds, and back."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.race.controllers import TUNABLE, ControllerKind, space_of
from hotlap.tuners.unit_box import UnitBox, latin_hypercube

TUNED = TUNABLE[ControllerKind.MPC]
SPACE = space_of(ControllerKind.MPC, TUNED.low, TUNED.high, TUNED.default)
LOG = pytest.mark.parametrize("log", [True, False])


@LOG
@pytest.mark.parametrize("tied", [True, False])
def test_corners_of_the_box_are_the_bounds(log, tied):
    box = UnitBox(SPACE, (3, 5), log, tied)
    assert box.size == (5 if tied else 15)
    low, high = box.decode(np.array([np.zeros(box.size), np.ones(box.size)]))
    assert_allclose(low, np.tile(SPACE.low, (3, 1)), rtol=1e-12)
    assert_allclose(high, np.tile(SPACE.high, (3, 1)), rtol=1e-12)
    assert SPACE.contains(box.decode(np.random.default_rng(0).random((50, box.size))))


@LOG
def test_what_is_encoded_comes_back(log):
    box = UnitBox(SPACE, (3, 5), log)
    points = np.random.default_rng(1).random((4, 15))
    for point, parameters in zip(points, box.decode(points), strict=True):
        assert_allclose(box.encode(parameters), point, atol=1e-12)


@LOG
def test_tied_parameters_are_the_same_in_all_segments_and_encode_their_mean(log):
    box = UnitBox(SPACE, (3, 5), log, tied=True)
    parameters = box.decode(np.random.default_rng(2).random((1, 5)))[0]
    assert_array_equal(parameters, np.tile(parameters[0], (3, 1)))
    spread = UnitBox(SPACE, (3, 5), log).decode(np.array([np.repeat([0.2, 0.4, 0.9], 5)]))[0]
    assert_allclose(box.encode(spread), np.full(5, 0.5), atol=1e-12)


def test_a_box_of_logarithms_has_its_middle_at_the_geometric_mean():
    middle = UnitBox(SPACE, (1, 5), log=True).decode(np.full((1, 5), 0.5))[0, 0]
    assert_allclose(middle, np.sqrt(SPACE.low * SPACE.high))


def test_a_latin_hypercube_has_one_point_in_every_slice_of_every_axis_and_axes_differ():
    points = latin_hypercube(12, 5, np.random.default_rng(0))
    slices = np.sort(np.floor(12 * points).astype(int), axis=0)
    assert_array_equal(slices, np.tile(np.arange(12)[:, None], 5))
    assert len(np.unique(np.argsort(points, axis=0), axis=1).T) > 1
