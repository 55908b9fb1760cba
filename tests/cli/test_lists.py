"""`hotlap races`, `tracks`, `quadrotors`, `tuners` and `worlds`: what there is, all or some of it, for people and for programs."""

from __future__ import annotations

import pytest

from hotlap import tuners, worlds
from hotlap.cli import worlds as list_of_worlds
from hotlap.files.descriptions import Kind, load, names

LISTS = {
    "races": names(Kind.RACE),
    "tracks": names(Kind.TRACK),
    "quadrotors": names(Kind.QUADROTOR),
    "tuners": tuple(dict.fromkeys(name.partition(":")[0] for name in tuners.names())),
    "worlds": worlds.names(),
}
EACH = pytest.mark.parametrize("kind", LISTS)


@EACH
def test_everything_is_listed_on_a_line_that_a_terminal_shows(hotlap, kind):
    ran = hotlap(kind)
    assert (ran.code, ran.err) == (0, "")
    header, *lines = ran.out.split("\n\n")[0].splitlines()
    assert header.split()[0] == kind.removesuffix("s")
    assert tuple(line.split()[0] for line in lines) == LISTS[kind]
    assert all(len(line) <= 165 for line in lines)


@EACH
def test_a_document_has_the_same_rows(hotlap, kind):
    document = hotlap(kind, "--json").document
    assert list(document) == [kind]
    assert tuple(row["name"] for row in document[kind]) == LISTS[kind]


@EACH
def test_some_can_be_asked_for_by_name_and_by_pattern(hotlap, kind):
    last = LISTS[kind][-1]
    rows = hotlap(kind, last, f"{last[:3]}*", "--json").document[kind]
    assert {row["name"] for row in rows} == {name for name in LISTS[kind] if name.startswith(last[:3])}


@EACH
@pytest.mark.parametrize(("word", "said"), [("no-such-*", "hotlap: no-such-*: matches no built-in "), ("no-such", "hotlap: there is no ")])
def test_what_is_not_there_is_one_clear_line(hotlap, kind, word, said):
    ran = hotlap(kind, word)
    assert (ran.code, ran.out) == (2, "")
    assert ran.err.startswith(said)
    assert ran.err.count("\n") == 1


def test_races_of_a_set(hotlap):
    rows = hotlap("races", "real", "circle-34", "--json").document["races"]
    assert [row["name"] for row in rows] == [*(name for name in LISTS["races"] if name.startswith("real-")), "circle-34"]


def test_presets_of_a_tuner_are_its_own_and_the_default_is_marked(hotlap):
    rows = {row["name"]: row for row in hotlap("tuners", "--json").document["tuners"]}
    assert [f"{name}:{preset}" for name, row in rows.items() for preset in row["presets"]] == list(tuners.names())
    assert [name for name, row in rows.items() if row["default"]] == [tuners.DEFAULT]
    assert all(len(row["what"]) > 20 and "(" not in row["what"] for row in rows.values())
    (only,) = hotlap("tuners", "cma_es:l*", "--json").document["tuners"]
    assert (only["name"], only["presets"]) == ("cma_es", ["log"])


def test_figures_of_tracks_and_quadrotors_are_theirs(hotlap):
    track = {row["name"]: row for row in hotlap("tracks", "--json").document["tracks"]}["circle"]
    assert (track["gates"], track["height"]) == (12, 0.0)
    assert {"circle-20", "circle-34"} <= set(track["races"])
    vehicle = {row["name"]: row for row in hotlap("quadrotors", "--json").document["quadrotors"]}["hummingbird"]
    assert vehicle["mass"] == load("hummingbird").mass  # pyright: ignore[reportAttributeAccessIssue]  it is a quadrotor
    assert "circle-34" in vehicle["races"]


def test_a_world_says_what_it_still_needs(hotlap, monkeypatch):
    monkeypatch.setitem(list_of_worlds.PACKAGES, "rotorpy", "no_such_package")
    rows = {row["name"]: row for row in hotlap("worlds", "--json").document["worlds"]}
    assert rows["built-in"]["ready"]
    assert (rows["rotorpy"]["ready"], rows["rotorpy"]["needs"]) == (False, "pip install 'hotlap[rotorpy]'")
    assert "a simulator that runs" in rows["airsim"]["needs"]
