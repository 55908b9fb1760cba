"""`hotlap fly`: parameters once more."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from hotlap.api.flown import COLUMNS
from hotlap.core.seeds import Stream, flight_seeds

pytestmark = pytest.mark.usefixtures("faked")
KEYS = {"seed", "completion", "lap_time", "cost", "end", "ending", "cause", "failed_segment", "mean_error", "max_error"}


def test_tuned_parameters_fly_better_than_the_default_ones(hotlap):
    hotlap("tune", "straight.toml", "--seed", "1", "--out", "mine")
    default, tuned = (
        hotlap("fly", "straight.toml", "--flights", "50", "--json", *more).document["flights"] for more in ([], ["--parameters", "mine"])
    )
    assert np.mean([flight["completion"] for flight in tuned]) > np.mean([flight["completion"] for flight in default])
    assert hotlap("fly", "straight.toml", "--parameters", "mine/parameters.toml").code == 0


def test_json_has_a_row_for_each_flight_with_null_for_what_is_not_there(hotlap):
    ran = hotlap("fly", "straight.toml", "--flights", "40", "--seed", "3", "--json")
    assert ran.code == 0
    assert (ran.document["race"], ran.document["world"]) == ("straight", "fake")
    rows = ran.document["flights"]
    assert [row["seed"] for row in rows] == flight_seeds(3, Stream.DEMONSTRATION, 0, 40).tolist()
    assert all(set(row) == KEYS for row in rows)
    assert {row["end"] for row in rows} == {"finished", "missed"}
    for row in rows:
        complete = row["end"] == "finished"
        assert (row["completion"] == 1, row["failed_segment"] is None, row["lap_time"] is not None) == (complete,) * 3
        assert row["ending"].startswith("all" if complete else "missed gate")
        assert row["cause"] is None


def test_people_read_how_many_held_and_where_the_others_ended(hotlap):
    ran = hotlap("fly", "straight.toml", "--flights", "40")
    assert ran.out.startswith("straight: 40 flights\n")
    assert " % of 40 flights [" in ran.out
    ends = [line.split() for line in ran.out.splitlines() if "gate " in line]
    missed = hotlap("fly", "straight.toml", "--flights", "40", "--json").out.count('"missed"')
    assert sum(int(words[0]) for words in ends) == missed > 0
    assert all(words[1:3] == ["missed", "gate"] for words in ends)


def test_the_same_seed_gives_the_same_flights_and_another_others(hotlap):
    first, again, other = (hotlap("fly", "straight.toml", "--seed", seed, "--json").out for seed in ("0", "0", "1"))
    assert first == again != other


def test_a_log_has_a_row_for_each_step(hotlap, here):
    ran = hotlap("fly", "straight.toml", "--log", "log.csv", "--flights", "2")
    assert ran.code == 0
    assert ran.out.endswith("log written to log.csv\n")
    with (here / "log.csv").open() as file:
        header, *rows = csv.reader(file)
    assert tuple(header) == COLUMNS
    assert [len(row) for row in rows] == [len(COLUMNS)] * 3
