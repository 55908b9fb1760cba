"""The box follows its rules, candidates lie in it, and the search finds its way."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from hotlap import tuners
from hotlap.tuners import trust_region
from hotlap.tuners.surrogates.gaussian_process import Kernel
from hotlap.tuners.trust_region import LEAST_INITIAL, PRESETS, TrustRegion, TrustRegionSettings, shifted_sobol
from hotlap.tuners.unit_box import latin_hypercube

from . import laws
from .test_contract import SEGMENTS, SPACE, judge, play, start

SIZE = SPACE.size * SEGMENTS


def begun(settings: TrustRegionSettings = PRESETS["default"], segments: int = SEGMENTS) -> TrustRegion:
    """A search that has flown its first points, all alike."""
    tuner = TrustRegion("under test", settings)
    tuner.start(SPACE.first_guess(segments), SPACE, np.random.default_rng(1))
    while len(tuner._waiting):
        asked = tuner.ask(64)
        tuner.tell(asked, laws.make_scores(np.full(len(asked), 100.0)))
    return tuner


def fly(tuner: TrustRegion, costs: list[float]) -> float:
    """Tell costs of points anywhere, one flight after the other; the side of the box."""
    for cost in costs:
        tuner._waiting = np.full((1, tuner._size), 0.5)
        tuner.tell(tuner.ask(1), laws.make_scores(np.array([cost])))
    return tuner._side


def test_three_successes_in_a_row_double_the_box_up_to_its_largest_side():
    assert fly(begun(), [90.0, 80.0]) == 0.8
    assert fly(begun(), [90.0, 80.0, 90.0, 70.0, 60.0]) == 0.8
    assert fly(begun(), [90.0, 80.0, 70.0]) == 1.6
    assert fly(begun(), [90.0, 80.0, 70.0, 60.0, 50.0, 40.0]) == 1.6


def test_as_many_failures_as_axes_halve_the_box():
    assert fly(begun(), [100.0] * (SIZE - 1)) == 0.8
    assert fly(begun(), [100.0] * SIZE) == 0.4
    assert fly(begun(), [100.0] * (SIZE - 1) + [50.0] + [100.0]) == 0.8
    assert fly(begun(PRESETS["tied"]), [100.0] * SPACE.size) == 0.4


@pytest.mark.parametrize(("cost", "side"), [(99.95, 0.4), (99.85, 0.8)])
def test_a_success_is_better_by_a_thousandth(cost, side):
    assert fly(begun(), [100.0] * (SIZE - 1) + [cost]) == side


def test_a_batch_that_fails_counts_as_many_times_as_it_has_flights():
    tuner = begun(TrustRegionSettings(batch=5))
    for side in (0.8, 0.8, 0.4):
        asked = tuner.ask(64)
        assert len(asked) == 5
        tuner.tell(asked, laws.make_scores(np.full(5, 200.0)))
        assert tuner._side == side


def test_a_box_that_is_too_small_is_given_up_and_nothing_of_it_kept():
    tuner = begun(PRESETS["tied"])
    assert fly(tuner, [100.0] * (6 * SPACE.size)) == 0.8 / 2**6 > 2**-7
    assert fly(tuner, [100.0] * SPACE.size) == 0.8
    assert len(tuner._costs) == 0
    assert len(tuner._waiting) == tuner._initial == LEAST_INITIAL
    assert np.ptp(tuner._waiting, axis=0).min() > 0.7


def test_the_first_points_fill_the_space_after_the_first_guess():
    for size, segments in ((LEAST_INITIAL, 1), (SIZE, SEGMENTS), (35, 7)):
        tuner = TrustRegion("under test", TrustRegionSettings())
        tuner.start(SPACE.first_guess(segments), SPACE, np.random.default_rng(1))
        assert len(tuner._waiting) == 1 + size


def test_a_latin_hypercube_has_one_point_in_every_slice():
    points = latin_hypercube(12, 5, np.random.default_rng(0))
    np.testing.assert_array_equal(np.sort(np.floor(12 * points), axis=0), np.tile(np.arange(12.0)[:, None], 5))


def test_sobol_s_points_stay_even_when_shifted():
    points, others = (shifted_sobol(500, 7, np.random.default_rng(seed)) for seed in (0, 1))
    assert points.shape == (256, 7)
    assert not np.array_equal(points, others)
    for axis in points.T:
        counts = np.histogram(axis, bins=16, range=(0, 1))[0]
        assert np.abs(counts - 16).max() <= 1


def test_the_box_is_longer_along_axes_of_longer_length_and_has_the_volume_of_a_cube():
    tuner, lengths = begun(segments=1), np.array([0.1, 0.2, 0.4, 0.8, 1.6])
    tuner._side = 0.1
    offsets = tuner._candidates(np.full(5, 0.5), lengths) - 0.5
    sides = 2 * np.abs(offsets).max(axis=0)
    np.testing.assert_allclose(sides / sides[0], lengths / lengths[0], rtol=0.05)
    assert sides.prod() == pytest.approx(0.1**5, rel=0.1)


def test_candidates_move_along_about_twenty_axes_of_many_and_never_along_none(monkeypatch):
    tuner = begun(segments=10)
    moved = (tuner._candidates(np.full(50, 0.5), np.ones(50)) != 0.5).sum(axis=1)
    assert moved.mean() == pytest.approx(20, rel=0.05)
    monkeypatch.setattr(trust_region, "MOVED", 0.5)
    moved = (tuner._candidates(np.full(50, 0.5), np.ones(50)) != 0.5).sum(axis=1)
    assert (moved == 1).mean() > 0.7
    assert moved.min() == 1


def test_the_box_lies_around_the_lowest_posterior_mean_and_not_around_a_lucky_flight(monkeypatch):
    tuner = begun(PRESETS["tied"])
    rng = np.random.default_rng(3)
    tuner._points = np.vstack([0.2 + 0.02 * rng.random((20, 5)), 0.8 + 0.02 * rng.random((20, 5))])
    tuner._costs = np.concatenate([np.full(20, 10.0), np.full(20, 20.0)])
    tuner._costs[30] = 5.0
    tuner._kernel, tuner._fitted = Kernel(np.full(5, 0.5), 0.2), 40
    centres, candidates = [], tuner._candidates
    monkeypatch.setattr(tuner, "_candidates", lambda centre, lengths: centres.append(centre) or candidates(centre, lengths))
    tuner.ask(1)
    assert centres[0].max() < 0.3


def test_what_is_drawn_is_low_where_the_process_knows_it():
    tuner = begun(PRESETS["tied"])
    tuner._points = latin_hypercube(100, 5, np.random.default_rng(4))
    tuner._costs = ((tuner._points - 0.6) ** 2).sum(axis=1)
    drawn = tuner._draw(8)
    assert len(np.unique(drawn, axis=0)) == 8
    assert ((drawn - 0.6) ** 2).sum(axis=1).max() < np.quantile(tuner._costs, 0.2)


def test_a_flight_without_a_cost_is_fitted_as_a_little_worse_than_the_others():
    tuner = begun()
    fly(tuner, [50.0, np.nan, np.inf, 1e300, 60.0])
    costs = tuner._remembered()[1][-5:]
    assert costs[1] == costs[2] == costs[3]
    assert 100.0 < costs[1] < 200.0
    assert costs[0] == 50.0


def test_dense_costs_are_used_where_they_are_asked_for():
    for name, expected in (("dense", 2.0), ("default", 1.0)):
        tuner = start(f"trust_region:{name}")
        tuner.tell(tuner.ask(1), replace(laws.make_scores(np.ones(1)), dense=np.full(1, 2.0)))
        assert tuner._costs[0] == expected


def test_tied_moves_all_segments_alike_and_the_others_do_not():
    tied, free = play(start("trust_region:tied"), 40), play(start("trust_region:default"), 40)
    assert (tied == tied[:, :1]).all()
    assert not (free[1:] == free[1:, :1]).all()


def test_raw_fills_the_bounds_and_the_default_their_logarithms():
    middles = {name: np.median(play(start(f"trust_region:{name}"), SIZE + 1)[1:, :, 0]) for name in ("raw", "default")}
    assert middles["raw"] == pytest.approx(500, rel=0.15)
    assert middles["default"] == pytest.approx(np.sqrt(1000), rel=0.4)


def test_restored_with_points_that_are_not_told_yet_it_goes_on_as_it_would():
    kept, resumed = (TrustRegion("under test", TrustRegionSettings(batch=4)) for _ in range(2))
    for tuner, seed in ((kept, 1), (resumed, 9)):
        tuner.start(SPACE.first_guess(SEGMENTS), SPACE, np.random.default_rng(seed))
    play(kept, 30, n=6)
    pending = kept.ask(4)
    resumed.restore(json.loads(json.dumps(kept.state(), allow_nan=False)))
    np.testing.assert_array_equal(resumed.ask(4), pending)
    kept.tell(pending, judge(pending))
    resumed.tell(pending, judge(pending))
    np.testing.assert_array_equal(play(resumed, 20), play(kept, 20))


@pytest.mark.parametrize("name", ["default", "tied"])
def test_it_descends_a_bowl_far_below_what_chance_finds(name):
    def bowl(parameters):
        return laws.make_scores(((SPACE.to_unit(parameters) - 0.3) ** 2).sum(axis=(1, 2)))

    def lowest(tuner):
        tuner.start(SPACE.first_guess(2), SPACE, np.random.default_rng(6))
        return bowl(play(tuner, 100, scores=bowl)).cost.min()

    assert lowest(tuners.build(f"trust_region:{name}")) < 0.1 * lowest(tuners.build("random_search:log_uniform"))
