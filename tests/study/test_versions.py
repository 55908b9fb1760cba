"""What a study was tuned with, and what is of another version now."""

from __future__ import annotations

import pytest

from hotlap.study import versions
from hotlap.study.versions import describe_changes, versions_now
from studies import carry, configure


@pytest.fixture(autouse=True)
def _installed(monkeypatch):
    monkeypatch.setattr(versions, "_simulators", lambda: iter([("betaflight", "4.6.1")]))


def test_a_study_keeps_the_versions_of_simulators_too(tmp_path):
    ((_, kept), *_) = carry(tmp_path / "s", configure()).openings
    assert kept == versions_now()
    assert kept["betaflight"] == "4.6.1"


def test_another_firmware_is_told_where_it_is_flown_and_in_one_line():
    before = {**versions_now(), "betaflight": "4.6.0"}
    told = "betaflight is 4.6.1, and was 4.6.0 when the study was tuned"
    assert describe_changes(before, ["built-in", "betaflight"]) == told
    assert describe_changes(before, ["built-in", "betaflight:my-diff.txt"]) == told
    assert describe_changes(before, ["built-in", "rotorpy"]) == ""


def test_nothing_is_told_of_what_is_the_same_or_was_not_kept():
    assert describe_changes(versions_now(), ["built-in", "betaflight"]) == ""
    assert describe_changes({}, ["built-in", "betaflight"]) == ""


def test_another_hotlap_is_told_whatever_is_flown():
    assert describe_changes({**versions_now(), "hotlap": "0.0.1"}, ["built-in"]).startswith("hotlap is ")
