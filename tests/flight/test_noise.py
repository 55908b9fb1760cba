"""Noise is nearly Gaussian, and nothing but seed, step and channel decides it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.flight import noise

from .kept import kept

COUNT = 20_000
CHANNELS = {
    "every step": [noise.THRUST, *(noise.RATES + k for k in range(3)), *(noise.WIND + k for k in range(3))]
    + [noise.MEASURED + k for k in range(9)],
    "the first": [first + k for first in (noise.POSITION, noise.VELOCITY, noise.ATTITUDE) for k in range(3)]
    + [noise.BIAS, noise.HEADING, noise.HEADING + 1],
}


@kept
def draw(seeds: np.ndarray, steps: np.ndarray, channels: np.ndarray) -> np.ndarray:
    out = np.zeros(len(seeds))
    for i in range(len(out)):
        out[i] = noise.normal(seeds[i], steps[i], channels[i])
    return out


def series(vary: str, other: int = 0, count: int = COUNT) -> np.ndarray:
    """Numbers along one of seed, step and channel; `other` shifts one of the rest."""
    index, fixed = np.arange(count), np.full(count, 3)
    if vary == "seed":
        return draw(index, fixed, fixed + other)
    if vary == "step":
        return draw(fixed + other, index, fixed)
    return draw(index, index // noise.CHANNELS + other, index % noise.CHANNELS)


def correlation(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.mean(a * b))


each_way = pytest.mark.parametrize("vary", ["seed", "step", "channel"])


@each_way
def test_mean_and_variance_are_those_of_a_normal_number(vary):
    values = series(vary)
    assert abs(values.mean()) < 4 / np.sqrt(COUNT)
    assert_allclose(values.var(), 1.0, atol=6 / np.sqrt(COUNT))
    assert_allclose(np.mean(values**3), 0.0, atol=0.1)
    assert_allclose(np.mean(values**4), 2.7, atol=0.15)  # of a sum of four uniform numbers; a Gaussian has 3


@each_way
def test_it_never_goes_far(vary):
    values = np.abs(series(vary))
    assert values.max() < 2 * np.sqrt(3)
    assert values.max() > 3.0


@each_way
def test_neighbours_have_nothing_in_common(vary):
    values, others = series(vary), series(vary, 1)
    for shift in (1, 2, 7):
        assert abs(correlation(values[shift:], values[:-shift])) < 4 / np.sqrt(COUNT)
    assert abs(correlation(values, others)) < 4 / np.sqrt(COUNT)
    assert abs(correlation(values**2 - 1, others**2 - 1)) < 8 / np.sqrt(COUNT)


def test_flights_of_neighbouring_runs_have_nothing_in_common():
    """Seeds of runs lie millions apart."""
    index, fixed = np.arange(COUNT), np.full(COUNT, 5)
    values = draw(index, fixed, fixed)
    for apart in (10**6, 4 * 10**6, 2**32):
        assert abs(correlation(values, draw(index + apart, fixed, fixed))) < 4 / np.sqrt(COUNT)


def test_it_is_the_same_every_time():
    """Other numbers would change every flight that was ever recorded."""
    assert_array_equal(series("seed"), series("seed"))
    assert_allclose(series("seed", count=3), [2.3650781657, 0.2400810170, 0.4131380955], atol=1e-9)


@pytest.mark.parametrize("channels", CHANNELS.values(), ids=CHANNELS)
def test_channels_do_not_overlap(channels):
    assert len(set(channels)) == len(channels)
    assert max(channels) < noise.CHANNELS
