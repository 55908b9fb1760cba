"""Suites and patterns stand for built-in races; all other words stay what they are."""

from __future__ import annotations

import pytest

from hotlap.core.errors import InputError
from hotlap.files.descriptions import Kind, names
from hotlap.files.suites import SUITES, expand
from hotlap.reproduce.published import RACES

KNOWN = names(Kind.RACE)


def test_all_is_all_and_every_other_suite_some():
    assert expand(["all"], KNOWN, "race") == list(KNOWN)
    for suite in set(SUITES) - {"all"}:
        assert 3 < len(expand([suite], KNOWN, "race")) < len(KNOWN)


def test_the_default_suite_is_that_of_the_paper_in_its_order():
    assert expand(["default"], KNOWN, "race") == list(RACES)


def test_no_suite_has_the_name_of_a_race():
    assert not set(SUITES) & set(KNOWN)


def test_words_are_taken_in_their_order_and_each_race_once():
    asked = ["circle-34", "circle-*", "mine.toml", "airsim-circle-??", "circle-20"]
    assert expand(asked, KNOWN, "race") == ["circle-34", "circle-20", "mine.toml", "airsim-circle-20", "airsim-circle-34"]


def test_a_file_may_be_called_like_a_pattern(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "race[1].toml").touch()
    assert expand(["race[1].toml"], KNOWN, "race") == ["race[1].toml"]


def test_a_pattern_that_matches_nothing_is_refused_and_says_where_to_look():
    with pytest.raises(InputError, match=r"^circel-\*: matches no built-in race; hotlap races lists them$"):
        expand(["circle-34", "circel-*"], KNOWN, "race")
