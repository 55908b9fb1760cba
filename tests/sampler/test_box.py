"""A search space as a box: every value there and back, on its grid, within its range."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some
from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

from hotlap.optuna.box import Axis, Box

DISTRIBUTIONS = [
    FloatDistribution(-3.0, 5.0),
    FloatDistribution(1e-6, 1e3, log=True),
    FloatDistribution(-1.0, 1.0, step=0.25),
    IntDistribution(-4, 9),
    IntDistribution(1, 1000, log=True),
    IntDistribution(0, 20, step=5),
]
EVERY = pytest.mark.parametrize("distribution", DISTRIBUTIONS, ids=str)


@EVERY
@given(share=some.floats(0, 1))
def test_any_share_is_a_value_that_the_distribution_holds(distribution, share):
    value = Axis("x", distribution).decode(share)
    assert type(value) is (int if isinstance(distribution, IntDistribution) else float)
    assert distribution._contains(distribution.to_internal_repr(value))


@EVERY
@given(share=some.floats(0, 1))
def test_a_value_comes_back(distribution, share):
    axis = Axis("x", distribution)
    value = axis.decode(share)
    assert axis.decode(axis.encode(value)) == pytest.approx(value, rel=1e-9, abs=1e-12)
    assert 0 <= axis.encode(value) <= 1


@pytest.mark.parametrize("distribution", [each for each in DISTRIBUTIONS if each.step is not None and not each.log], ids=str)
def test_every_point_of_a_grid_has_an_equal_share(distribution):
    values = [Axis("x", distribution).decode(share) for share in (np.arange(100_000) + 0.5) / 100_000]
    counts = np.unique(values, return_counts=True)[1]
    assert np.ptp(counts) <= 2


def test_only_numbers_of_more_than_one_value_are_axes():
    box = Box.of(
        {"b": IntDistribution(0, 3), "c": CategoricalDistribution(("x", "y")), "a": FloatDistribution(0, 1), "one": IntDistribution(2, 2)}
    )
    assert box.space.names == ("a", "b")
    assert box.space.contains(box.space.first_guess(1))


def test_a_trial_of_other_ranges_is_not_in_the_box():
    box = Box.of({"a": FloatDistribution(0, 1)})
    assert box.holds({"a": 0.5, "z": "anything"})
    assert not box.holds({"a": 1.5})
    assert not box.holds({"z": 0.5})


def test_fingerprints_tell_ranges_apart():
    spaces = [{"a": FloatDistribution(0, 1)}, {"a": FloatDistribution(0, 2)}, {"b": FloatDistribution(0, 1)}, {"a": IntDistribution(0, 1)}]
    assert len({Box.of(space).fingerprint for space in spaces}) == 4
