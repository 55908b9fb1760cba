"""The tuner that looks at every gate: it parts segments where that pays, and does not mistake a cost for gates."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from hotlap import tuners
from hotlap.core.records import Scores
from hotlap.tuners.gate_gp import MARGIN, GateGp, GateGpSettings
from hotlap.tuners.surrogates.gate_process import FARTHEST, NEAREST
from hotlap.tuners.walk import MEMORY, fitted

from .laws import make_scores, make_space

SPACE = make_space(1.0, float(np.exp(6.0)), size=3)
SEGMENTS, GATE_SEGMENTS = 4, np.array([0, 0, 1, 2, 2, 3])
WANTED = np.linspace(1.5, 4.5, SEGMENTS)  # logarithm of every parameter of a segment
RIM = 1.2  # of the distance from it at which a gate is missed


def fly(parameters: np.ndarray, noise: np.random.Generator, unreached: bool = False) -> Scores:
    """Gates that are missed where the parameters of their segment are far from what it wants; a crash hides those behind."""
    away = np.sqrt(((np.log(parameters) - WANTED[:, None]) ** 2).mean(axis=2))[:, GATE_SEGMENTS] / RIM
    ratio = away * np.exp(0.05 * noise.standard_normal(away.shape))
    passed = np.cumprod(ratio < 1, axis=1).sum(axis=1) / len(GATE_SEGMENTS)
    miss = np.log(np.maximum(ratio, 1e-6))
    if unreached:
        crashed = np.cumsum(ratio > 2, axis=1) > 0
        miss = np.where(crashed, np.nan, miss)
    dense = np.log1p(np.minimum(np.nan_to_num(np.exp(miss), nan=40.0), 40.0) ** 8).sum(axis=1)
    segments = np.tile(GATE_SEGMENTS, (len(parameters), 1))
    return replace(make_scores(dense), completion=passed, gate_miss=miss, gate_segment=segments)


def flights_until_complete(name: str, seed: int, budget: int = 150, unreached: bool = False) -> int:
    tuner, noise = tuners.build(name), np.random.default_rng([seed, 1])
    tuner.start(SPACE.first_guess(SEGMENTS), SPACE, np.random.default_rng(seed))
    for flight in range(1, budget + 1):
        asked = tuner.ask(8)
        scores = fly(asked, noise, unreached)
        tuner.tell(asked, scores)
        if scores.complete.any():
            return flight
    return 2 * budget


def test_no_set_for_all_segments_would_do():
    line = np.exp(np.linspace(0, 6, 61))
    alike = np.tile(line[:, None, None], (1, SEGMENTS, 3))
    assert not fly(alike, np.random.default_rng(0)).complete.any()


@pytest.mark.parametrize("unreached", [False, True])
def test_it_parts_the_segments_sooner_than_one_process_for_the_whole_cost(unreached):
    seeds = range(6)
    by_gate = [flights_until_complete("gate_gp", seed, unreached=unreached) for seed in seeds]
    whole = [flights_until_complete("gate_gp:whole", seed, unreached=unreached) for seed in seeds]
    assert np.median(by_gate) < 60
    assert np.median(by_gate) < 0.7 * np.median(whole)


def test_a_cost_of_its_own_is_what_counts():
    def away(parameters: np.ndarray) -> np.ndarray:
        return ((np.log(parameters) - 5.0) ** 2).mean(axis=(1, 2))

    tuner, noise = tuners.build("gate_gp"), np.random.default_rng(0)
    tuner.start(SPACE.first_guess(SEGMENTS), SPACE, np.random.default_rng(0))
    for _ in range(40):
        asked = tuner.ask(1)
        tuner.tell(asked, fly(asked, noise).with_costs(away(asked)))
    assert away(tuner.ask(1))[0] < 1.0 < away(SPACE.first_guess(SEGMENTS)[None])[0]


def begin(name: str = "gate_gp", seed: int = 0) -> tuners.Tuner:
    tuner = tuners.build(name)
    tuner.start(SPACE.first_guess(SEGMENTS), SPACE, np.random.default_rng(seed))
    return tuner


def play(tuner: tuners.Tuner, flights: int, noise: np.random.Generator) -> np.ndarray:
    """All that was asked for in so many flights, some of which crash."""
    asked = []
    for _ in range(flights):
        asked.append(tuner.ask(1))
        tuner.tell(asked[-1], fly(asked[-1], noise, unreached=True))
    return np.concatenate(asked)


@pytest.mark.parametrize("before", [3, 30, 205])
@pytest.mark.parametrize("name", ["gate_gp:default", "gate_gp:one_generation"])
def test_saved_and_restored_it_goes_on_with_its_gates(name, before):
    kept, flown = begin(name), SPACE.from_unit(np.random.default_rng(3).random((before, SEGMENTS, 3)))
    kept.tell(flown, fly(flown, np.random.default_rng(4), unreached=True))
    play(kept, 3, np.random.default_rng(0))
    saved = json.dumps(kept.state(), allow_nan=False)
    assert before < 30 or "null" in saved, "some gates were not reached"
    resumed = begin(name, seed=9)
    resumed.restore(json.loads(saved))
    np.testing.assert_array_equal(play(resumed, 15, np.random.default_rng(1)), play(kept, 15, np.random.default_rng(1)))
    assert json.dumps(resumed.state()) == json.dumps(kept.state())


def test_flights_of_which_nothing_is_known_leave_it_within_the_bounds():
    tuner = begin()
    for _ in range(30):
        asked = tuner.ask(1)
        assert SPACE.contains(asked)
        lost = replace(fly(asked, np.random.default_rng(0)), gate_miss=np.full((1, len(GATE_SEGMENTS)), np.nan), dense=np.array([np.nan]))
        tuner.tell(asked, lost)


def test_the_best_and_the_latest_flights_are_fitted_and_no_more_than_memory_holds():
    costs = np.random.default_rng(0).permutation(500).astype(float)
    chosen = fitted(costs)
    assert len(chosen) <= MEMORY < len(costs)
    assert set(np.argsort(costs)[: MEMORY // 2]) | set(range(500 - MEMORY // 2, 500)) == set(chosen.tolist())
    assert (np.diff(chosen) > 0).all(), "in the order flown"
    np.testing.assert_array_equal(fitted(costs[:MEMORY]), np.arange(MEMORY))


def test_each_point_keeps_its_own_misses_when_some_are_left_out():
    tuner = GateGp("gate_gp", GateGpSettings())
    tuner.start(SPACE.first_guess(SEGMENTS), SPACE, np.random.default_rng(0))
    points = SPACE.from_unit(np.random.default_rng(1).random((300, SEGMENTS, 3)))
    scores = fly(points, np.random.default_rng(2))
    tuner.tell(points, scores)
    chosen = fitted(scores.dense)
    groups = tuner._groups(scores.dense, chosen)
    assert [group.columns.tolist() for group in groups] == [[0, 1], [2], [3, 4], [5]]
    for group in groups:
        np.testing.assert_array_equal(group.values, np.clip(scores.gate_miss[chosen][:, group.columns], NEAREST, FARTHEST))


def test_a_candidate_is_worth_less_the_nearer_it_comes_to_a_miss_and_what_is_not_known_is_hoped_for():
    tuner = GateGp("gate_gp", GateGpSettings())
    tuner.start(SPACE.first_guess(SEGMENTS), SPACE, np.random.default_rng(0))
    tuner.tell(SPACE.first_guess(SEGMENTS)[None], fly(SPACE.first_guess(SEGMENTS)[None], np.random.default_rng(0)))
    means, noises = np.array([[-1.0], [-MARGIN], [0.0], [0.5]]), np.array([0.2])
    values = tuner._acquisition(means, np.zeros((4, 1)), noises, 1.0)
    assert values[1] == pytest.approx(np.log(2)), "with just enough to spare it passes in half of the cases"
    assert (np.diff(values) > 0).all()
    assert (tuner._acquisition(means, np.full((4, 1), 0.3), noises, 1.0) < values).all()
    np.testing.assert_array_equal(tuner._acquisition(means, np.full((4, 1), 0.3), noises, 0.0), values)
