"""A training set: kept, read, checked, and what it would be without a track."""

from __future__ import annotations

import json

import numpy as np
import pytest

from first_guess.small import DEFAULT, GOOD, OTHER, make_race, make_set
from hotlap.core.errors import InputError
from hotlap.files.descriptions import Kind, load_track, names
from hotlap.first_guess.training_set import load_training_set, shipped, write_training_set

LEAST = make_set(make_race("a", "048", own=(1,)), make_race("b", "840", own=(2,)), make_race("a", "444", own=(1, 0)))


def test_it_is_read_as_it_was_written(tmp_path):
    path = tmp_path / "set.json"
    path.write_text(write_training_set(LEAST), encoding="utf-8")
    assert load_training_set(path) == LEAST


def test_digits_are_shares():
    np.testing.assert_array_equal(LEAST.passed, [[0, 0.5, 1], [1, 0.5, 0], [0.5, 0.5, 0.5]])
    np.testing.assert_array_equal(LEAST.completed[0], [0, 4 / 9, 8 / 9])


def test_without_a_track_nothing_is_left_of_it():
    left = LEAST.without("a")
    assert [race.track for race in left.races] == ["b"]
    assert left.candidates == (DEFAULT, OTHER)
    assert left.passed.tolist() == [[1, 0]]
    assert left.races[0].own == (1,)
    assert LEAST.without("b").candidates == (DEFAULT, GOOD)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ("[]", "must be one JSON object"),
        ("{", "is no JSON document"),
        ({"flights": 10}, "flights: must be at most 9"),
        ({"candidates": [[1.0]]}, "candidates: a row has 1 entries where there are 5 names"),
        ({"races": []}, "races: "),
        ({"piece_features": ["delay"]}, "piece_features: there is no feature delay"),
        ({"race_features": ["weather"]}, "race_features: there is no feature weather"),
        ({"candidates": [[200.0, 500.0, 50.0, 10.0, 0.0]]}, "candidates[0][4]: must be greater than 0"),
        ({"flights": 7}, "races: passed says of a candidate that it passed more than 7 flights"),
        ("[" * 100_000, "is no JSON document"),
        ({"names": ["a"]}, "candidates: a row has 5 entries where there are 1 names"),
        ({"speed": 1}, "speed: "),
    ],
)
def test_what_does_not_fit_is_named(tmp_path, change, complaint):
    path = tmp_path / "set.json"
    content = change if isinstance(change, str) else json.dumps({**json.loads(write_training_set(LEAST)), **change})
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InputError) as refused:
        load_training_set(path)
    assert str(refused.value).startswith(f"{path}: {complaint}")


@pytest.mark.parametrize("own", [(3,), (-1,)])
def test_a_candidate_that_is_not_there_is_named(own):
    with pytest.raises(ValueError, match="own names a candidate that is not there"):
        make_set(make_race("a", "000", own=own))


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(InputError, match=r"none.json: there is no such file"):
        load_training_set(tmp_path / "none.json")


def test_what_is_shipped_has_no_track_that_claims_are_made_about():
    tracks = {race.track for race in shipped().races}
    built_in = {load_track(name).name for name in names(Kind.TRACK)}
    assert tracks & built_in == {"soccer-medium"}
    assert all("-1" in track for track in tracks - {"soccer-medium"})  # seeds from 1000 on


def test_what_is_shipped_was_flown_by_several_and_mostly_holds():
    races = shipped().races
    assert len({race.vehicle for race in races}) >= 5
    assert np.mean([race.validated >= 0.9 for race in races if race.tuned is not None]) > 0.85
