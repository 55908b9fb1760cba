"""The tuner that looks at every gate: it parts segments where that pays, and does not mistake a cost for gates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hotlap import tuners
from hotlap.parameters import ParameterSpace
from hotlap.records import Scores

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
    by_gate = [flights_until_complete("gatewise", seed, unreached=unreached) for seed in seeds]
    whole = [flights_until_complete("gatewise:whole", seed, unreached=unreached) for seed in seeds]
    assert np.median(by_gate) < 60
    assert np.median(by_gate) < 0.7 * np.median(whole)


def test_a_cost_of_its_own_is_what_counts():
    def away(parameters: np.ndarray) -> np.ndarray:
        return ((np.log(parameters) - 5.0) ** 2).mean(axis=(1, 2))

    tuner, noise = tuners.build("gatewise"), np.random.default_rng(0)
    tuner.start(SPACE.first_guess(SEGMENTS), SPACE, np.random.default_rng(0))
    for _ in range(40):
        asked = tuner.ask(1)
        tuner.tell(asked, fly(asked, noise).worth(away(asked)))
    assert away(tuner.ask(1))[0] < 1.0 < away(SPACE.first_guess(SEGMENTS)[None])[0]


def test_memory_is_bounded_and_the_best_is_kept():
    tuner, noise = tuners.build("gatewise:hasty"), np.random.default_rng(0)
    space = ParameterSpace(SPACE.names, SPACE.low, SPACE.high, np.exp(WANTED[:3]), SPACE.log_step)
    tuner.start(space.first_guess(SEGMENTS), space, np.random.default_rng(0))
    for _ in range(230):
        asked = tuner.ask(1)
        tuner.tell(asked, fly(asked, noise))
    assert len(tuner.state()["misses"]) == len(tuner.state()["points"]) == 230
    assert space.contains(tuner.ask(1))
