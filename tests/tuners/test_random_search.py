"""Random search draws from what each preset names."""

from __future__ import annotations

import numpy as np

from hotlap import tuners

from . import laws


def draw(preset: str, low: float, high: float, segments: int = 2, count: int = 4000) -> np.ndarray:
    tuner, space = tuners.build(f"random_search:{preset}"), laws.make_space(low, high, 3)
    tuner.start(space.first_guess(segments), space, np.random.default_rng(5))
    return tuner.ask(count)[1:]


def test_paper_draws_uniformly_with_variance_five_around_the_first_guess():
    offsets = draw("paper", 10.0, 1000.0) - 100.0
    np.testing.assert_allclose(offsets.var(axis=0), 5.0, rtol=0.06)
    np.testing.assert_allclose(offsets.mean(axis=0), 0.0, atol=0.15)
    assert 3.8 < np.abs(offsets).max() < np.sqrt(15)
    assert np.abs(np.corrcoef(offsets.reshape(-1, 6).T) - np.eye(6)).max() < 0.08


def test_uniform_fills_the_bounds_evenly_and_each_segment_by_itself():
    drawn = draw("uniform", 10.0, 1000.0)
    shares = np.histogram(drawn, bins=10, range=(10.0, 1000.0))[0] / drawn.size
    np.testing.assert_allclose(shares, 0.1, atol=0.01)
    assert abs(np.corrcoef(drawn[:, 0, 0], drawn[:, 1, 0])[0, 1]) < 0.08


def test_log_uniform_fills_the_logarithms_evenly_with_one_draw_for_all_segments():
    drawn = draw("log_uniform", 10.0, 1000.0)
    np.testing.assert_array_equal(drawn[:, 0], drawn[:, 1])
    shares = np.histogram(np.log(drawn[:, 0]), bins=10, range=(np.log(10), np.log(1000)))[0] / drawn[:, 0].size
    np.testing.assert_allclose(shares, 0.1, atol=0.012)
