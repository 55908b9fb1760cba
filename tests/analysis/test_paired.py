"""Paired comparisons see what pairing shows, find nothing where nothing is, and claim no more than few runs allow."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from hotlap.analysis.comparison import Run
from hotlap.analysis.paired import HEADS, holm, paired, paired_cells, sign_test, stratified_interval
from hotlap.analysis.statistics import bootstrap_interval, means


def make_run(tuner: str, race: str, seed: int, **changes) -> Run:
    spent = {"budget": 200, "flights": 30, "search_flights": 10, "confirmed": True, "successes": 45, "validation": 50}
    worth = {"completion": 1.0, "cost": 5.0, "lap_time": 5.0, "tuner_time": 0.3, "curve": ((1, 1.0),)}
    return Run(**{"race": race, "tuner": tuner, "seed": seed, **spent, **worth, **changes})


def both(n: int, races: str = "rs"):
    return [(tuner, race, seed) for tuner in ("a", "b") for race in races for seed in range(n)]


def test_a_small_advantage_on_every_seed_is_seen_though_races_and_seeds_differ_by_more():
    rng = np.random.default_rng(1)
    hard = {(race, seed): rng.integers(5, 40) for race in "rs" for seed in range(10)}
    runs = [make_run(t, race, seed, successes=int(hard[race, seed]) + 2 * (t == "a")) for t, race, seed in both(10)]
    (row,) = paired(runs)
    assert (row.tuner, row.against, row.pairs) == ("a", "b", 20)
    assert row.validated.value == pytest.approx(0.04)
    assert row.validated.interval is None
    assert row.validated.p < 0.001
    apart = [np.array([run.validated for run in runs if run.tuner == name]) for name in "ab"]
    unpaired = [bootstrap_interval(values, means) for values in apart]
    assert unpaired[0][0] < unpaired[1][1], "intervals of each tuner by itself overlap"


def test_nothing_is_found_where_nothing_is():
    (row,) = paired([make_run(*which) for which in both(5)])
    for difference in (row.confirmed, row.validated, row.lap_time):
        assert (difference.pairs, difference.value, difference.interval, difference.p) == (10, 0.0, None, 1.0)
    assert (row.fewer, row.more, row.flights_p) == (0, 0, 1.0)


def test_three_seeds_prove_nothing():
    runs = [make_run(t, race, seed, confirmed=t == "a", successes=50 * (t == "a")) for t, race, seed in both(3, "r")]
    (row,) = paired(runs)
    assert row.confirmed.value == row.validated.value == 1.0
    assert row.confirmed.p == row.validated.p == 0.25 == sign_test(3, 0)
    assert (row.lap_time.pairs, row.lap_time.p) == (0, 1.0)
    assert math.isnan(row.lap_time.value)


def test_who_never_confirms_needs_more_flights_than_anyone_who_does():
    runs = [make_run("a", "r", 0, search_flights=199), make_run("b", "r", 0, confirmed=False, search_flights=1)]
    runs += [make_run(t, "r", 1, confirmed=False) for t in "ab"]
    (row,) = paired(runs)
    assert (row.pairs, row.fewer, row.more) == (2, 1, 0)


def test_only_what_both_have_flown_is_compared():
    runs = [make_run("a", "r", seed) for seed in range(4)] + [make_run("b", "r", seed) for seed in (2, 3, 4)]
    assert paired(runs)[0].pairs == 2
    assert paired([make_run("a", "r", 0), make_run("b", "s", 0)])[0].pairs == 0
    assert paired(runs[:4]) == []
    assert paired_cells([]) == []


def test_laps_are_shares_so_that_long_races_do_not_decide():
    runs = [
        make_run(t, race, s, lap_time=long * (0.9 if t == "a" else 1.0))
        for race, long in (("r", 5.0), ("s", 50.0))
        for s in range(5)
        for t in "ab"
    ]
    (row,) = paired(runs)
    assert row.lap_time.value == pytest.approx(-0.1)


def test_an_interval_keeps_the_share_of_each_race():
    """All of the difference is between races: within them seeds do not differ, and nothing is left to chance."""
    values, races = np.array([0.0] * 5 + [1.0] * 5), ["r"] * 5 + ["s"] * 5
    assert stratified_interval(values, races, means) == (0.5, 0.5)
    low, high = stratified_interval(values, ["r"] * 10, means)
    assert low < 0.5 < high


def test_an_interval_covers_the_truth_about_as_often_as_it_says():
    rng = np.random.default_rng(0)
    draws = rng.normal(0.3, 1.0, (200, 20))
    inside = [low <= 0.3 <= high for low, high in (stratified_interval(row, ["r"] * 10 + ["s"] * 10, means) for row in draws)]
    assert 0.87 <= np.mean(inside) <= 0.99


def test_many_comparisons_are_corrected_for():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.5, 0.9]) == [1.0, 1.0]
    assert holm([]) == []
    two = [make_run(t, "r", seed, confirmed=t == "a") for t in "ab" for seed in range(6)]
    alone = paired(two)[0].confirmed.p
    more = paired([*two, *(make_run("c", "r", seed, confirmed=False) for seed in range(6))])
    assert {(row.tuner, row.against): row.confirmed.p for row in more}["a", "b"] == pytest.approx(3 * alone)


def test_cells_say_points_with_signs_and_documents_hold_no_words():
    runs = [make_run(t, "r", s, successes=45 if t == "a" else 30 + s, confirmed=t == "a" or s > 3) for t in "ab" for s in range(8)]
    rows = paired(runs)
    heads, cells = paired_cells(rows)
    assert heads == list(HEADS)
    assert len(cells) == len(HEADS)
    assert cells[:3] == ["a", "b", "8"]
    assert cells[3].startswith("+50 [+")
    assert cells[9] == "0.0"
    document = json.loads(json.dumps(rows[0].dump()))
    assert document["validated"]["low"] < document["validated"]["value"] < document["validated"]["high"]
    assert document["lap_time"] == {"pairs": 4, "value": 0.0, "p": 1.0, "low": None, "high": None}
