"""Functions drawn from a posterior have its mean and deviation."""

from __future__ import annotations

import numpy as np

from hotlap.tuners.surrogates.gaussian_process import Kernel
from hotlap.tuners.surrogates.posterior_paths import draw_paths

from .test_gaussian_process import ELSEWHERE, KERNEL, POINTS, VALUES


def test_drawn_functions_have_the_posterior_s_mean_and_deviation():
    posterior, rng = KERNEL.condition(POINTS, VALUES), np.random.default_rng(2)
    drawn = np.hstack([draw_paths(posterior, KERNEL.noise, 20, rng).at(ELSEWHERE) for _ in range(200)])
    mean, deviation = posterior.predict(ELSEWHERE)
    np.testing.assert_allclose(drawn.mean(axis=1), mean, atol=0.1 * deviation.max())
    np.testing.assert_allclose(drawn.std(axis=1), deviation, rtol=0.08)


def test_drawn_functions_pass_through_data_without_noise_and_differ_elsewhere():
    exact = Kernel(KERNEL.lengths, 1e-6)
    paths = draw_paths(exact.condition(POINTS, VALUES), exact.noise, 2, np.random.default_rng(3))
    np.testing.assert_allclose(paths.at(POINTS), np.repeat(VALUES[:, None], 2, axis=1), atol=0.02)
    apart = paths.at(ELSEWHERE)
    assert np.abs(apart[:, 0] - apart[:, 1]).max() > 0.1
