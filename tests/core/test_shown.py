"""Whatever is handed out has a short form, whatever comes in rows is a data frame, and digests see every digit."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pytest

from fake_world import FakeWorld, make_scenario
from hotlap.core.errors import InputError
from hotlap.core.records import Log
from hotlap.core.shown import Listed, Shown, brief, fitted, flat, html_table, in_full
from hotlap.files.descriptions import load_race, names
from hotlap.files.kinds import Kind
from hotlap.tuning.objective import Objective

LONGEST = 400


@dataclass(frozen=True, repr=False)
class Wide(Shown):
    """As long as can be."""

    name: str = "n" * 1000
    text: str = "<b>" * 500
    values: np.ndarray = field(default_factory=lambda: np.arange(10_000.0))
    many: tuple = tuple(range(5000))
    one: object = None
    other: object = None


@pytest.fixture(scope="module")
def flown():
    scenario = make_scenario()
    parameters = np.tile(scenario.space.first_guess(2), (30, 1, 1))
    return scenario, *Objective(scenario, FakeWorld()).fly_recorded(parameters, np.arange(30))


def short(one: object) -> bool:
    return all(len(text) < LONGEST for text in (repr(one), str(one), one._repr_html_()))


def test_short_forms_are_short_whatever_is_in_them():
    wide = Wide(one=Wide(), other=[Wide()] * 3)
    assert short(wide)
    assert short(Listed([wide] * 500))
    assert short(Listed())
    assert "<b>" not in wide._repr_html_()
    assert repr(Wide(name="a")).startswith("Wide(name='a', text='<b><b>")


@pytest.mark.parametrize("race", names(Kind.RACE))
def test_races_and_what_they_are_made_of_are_short_and_say_their_names(race):
    found = load_race(race)
    for one in (found, found.track, found.vehicle, found.controller, found.planning, found.judge):
        assert short(one), type(one)
    assert f"name='{found.name}'" in repr(found)
    assert f"<Track {found.track.name}>" in repr(found)


def test_flights_scores_and_scenarios_are_short_and_rows(flown):
    scenario, flights, scores = flown
    for one in (scenario, flights, scores, scenario.reference, scenario.segments, scenario.space):
        assert short(one)
    rows = flights.records()
    assert [row["seed"] for row in rows] == list(range(30))
    assert {row["end"] for row in rows} <= {"finished", "missed", "crashed"}
    assert [row["cost"] for row in scores.records()] == scores.cost.tolist()
    assert scenario.reference.records()[-1]["t"] == pytest.approx(scenario.reference.duration)


def test_a_log_has_the_columns_of_its_file():
    log = Log(np.arange(3.0), np.zeros((3, 13)), np.zeros((3, 6)), np.ones((3, 4)))
    assert short(log)
    row = log.records()[2]
    assert (row["t"], row["command_thrust"], row["u_6"]) == (2.0, 1.0, 0.0)
    assert np.isnan(row["thrust_effectiveness"])
    assert len(row) == 1 + 13 + 6 + 4 + 4


def test_a_list_of_results_is_a_tuple_with_a_short_form_and_rows(flown):
    space = flown[0].space
    some = Listed([space, space])
    assert some == (space, space)
    assert some[0] is space
    assert repr(some).startswith("<2 ParameterSpace: ")
    assert [row["names"] for row in some.records()] == [space.names] * 2


def test_rows_are_flat():
    assert flat(SimpleNamespace(dump=lambda: {"a": {"b": 1, "c": {}}, "d": None})) == {"a.b": 1, "a.c": {}, "d": None}


def test_a_frame_is_one_of_pandas_and_says_so_where_there_is_none(flown, monkeypatch):
    pandas = pytest.importorskip("pandas")
    frame = flown[1].to_frame()
    assert isinstance(frame, pandas.DataFrame)
    assert len(frame) == 30
    assert len(Listed([flown[0].space]).to_frame()) == 1
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(InputError, match="needs pandas: pip install pandas"):
        flown[1].to_frame()


def test_digests_see_what_short_forms_leave_out():
    race = load_race("circle-34")
    gates = race.track.gates
    last = gates[-1].model_copy(update={"position": (*gates[-1].position[:2], np.nextafter(gates[-1].position[2], 9))})
    other = race.model_copy(update={"track": race.track.model_copy(update={"gates": (*gates[:-1], last)})})
    assert repr(other) == repr(race)
    assert in_full(other) != in_full(race)
    values = np.arange(10_000.0)
    assert in_full(Wide()) != in_full(replace(Wide(), values=np.nextafter(values, 1e9)))
    assert in_full([race, {"a": race}]) == in_full((race, {"a": load_race("circle-34")}))


def test_parts_that_do_not_fit_are_left_out():
    assert fitted("<", ["a", "b"], ">") == "<a, b>"
    assert fitted("<", ["a" * 300, "b" * 300], ">").endswith(", ...>")
    assert (
        html_table("t", [("page", "a/report.html")])
        == '<table><caption>t</caption><tr><th>page<td><a href="a/report.html">report.html</a></table>'
    )
    assert brief(np.zeros((40, 5))) == "<40 x 5 numbers>"
