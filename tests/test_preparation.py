"""A race is made ready, and parameters fit it or are refused."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import hotlap
from fake_world import make_course
from hotlap.errors import InputError
from hotlap.files import save
from hotlap.preparation import differences, parameters_for, prepare
from hotlap.reference_csv import save_reference
from hotlap.saved_parameters import SavedParameters
from hotlap.segmentation import Rule, SegmentClass, Segments, segment

COURSE = make_course()


def saved(**changes) -> SavedParameters:
    values = np.arange(1.0, 11.0).reshape(2, 5) * [1, 100, 1, 1, 0.4] + [0, 0, 0, 0, 1]
    return replace(SavedParameters("straight", COURSE.space.names, COURSE.segments, values), **changes)


def test_a_race_with_a_reference_is_ready_without_planning(tmp_path, monkeypatch):
    monkeypatch.setattr("hotlap.preparation.plan", lambda *_: pytest.fail("planned"))
    save(tmp_path / "straight.toml", COURSE.race)
    save_reference(tmp_path / "plan.csv", COURSE.reference)
    for race in (COURSE.race, tmp_path / "straight.toml", str(tmp_path / "straight.toml")):
        course = prepare(race, tmp_path / "plan.csv")
        assert course.race == COURSE.race
        np.testing.assert_allclose(course.reference.gate_times, COURSE.reference.gate_times, atol=0.02)
        assert course.segments.duration == course.reference.duration


def test_a_race_is_planned_and_segmented(monkeypatch):
    asked = []
    monkeypatch.setattr("hotlap.preparation.plan", lambda race, cache: asked.append((race.name, cache)) or COURSE.reference)
    course = prepare("circle-34", cache=False)
    assert asked == [("circle-34", False)]
    assert course.reference is COURSE.reference


def test_parameters_fit_in_any_order_of_names():
    names = tuple(reversed(COURSE.space.names))
    turned = saved(names=names, values=saved().values[:, ::-1])
    np.testing.assert_array_equal(parameters_for(COURSE, turned, "x"), saved().values)
    assert differences(COURSE, turned) == ()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"names": ("a", "b", "c", "d", "e")}, "f: names: are a, b, c, d, e; the controller takes Q_pos_xy"),
        (
            {"segments": Segments(np.array([0.0]), (SegmentClass.FLAT,), 5.0), "race": "loop"},
            "f: segment: there are 1, tuned for loop; straight has 2",
        ),
        ({"values": saved().values * [[1], [100]]}, r"f: segment\[1\].Q_pos_z: 70000 is not within \[100, 1500\]"),
    ],
)
def test_parameters_that_do_not_fit_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        parameters_for(COURSE, saved(**changes), "f")


def test_what_differs_but_fits_is_said():
    other = saved(race="loop", segments=replace(COURSE.segments, classes=(SegmentClass.STEEP, SegmentClass.FLAT)))
    assert differences(COURSE, other) == (
        "tuned for loop, used for straight",
        "tuned for segments steep, flat, used for flat, ascent",
    )


def test_segments_that_are_other_parts_of_the_same_flight_are_said():
    halves = replace(COURSE.segments, starts=np.array([0.0, 2.55]))
    assert differences(COURSE, saved(segments=halves)) == ()
    others = replace(COURSE.segments, starts=np.array([0.0, 3.3]))
    assert differences(COURSE, saved(segments=others)) == ("tuned for segments that begin at 0.0, 3.3 s, used for 0.0, 2.5 s",)
    shared = Segments(np.array([0.0, 2.5, 4.0]), (*COURSE.segments.classes, SegmentClass.FLAT), 5.0, (0, 1, 0))
    assert differences(COURSE, saved(segments=shared)) == ("tuned for segments that begin at 0.0, 2.5, 4.0 s, used for 0.0, 2.5 s",)


@pytest.mark.parametrize("rule", list(Rule))
def test_a_race_is_cut_by_the_rule_that_is_asked_for(monkeypatch, rule):
    monkeypatch.setattr("hotlap.preparation.plan", lambda *_, **__: COURSE.reference)
    segments, wanted = prepare(COURSE.race, segments=rule).segments, segment(COURSE.reference, rule)
    assert segments.starts.tolist() == wanted.starts.tolist()
    assert segments.classes == wanted.classes


@pytest.mark.parametrize("name", [name for name in hotlap.__all__ if name != "BuiltIn"])
def test_every_public_name_is_there_and_documented(name):
    assert getattr(hotlap, name).__doc__
    assert name in dir(hotlap)


def test_the_list_of_public_names_is_sorted_and_complete():
    assert sorted(hotlap.__all__) == sorted(hotlap._HOME)
    with pytest.raises(AttributeError, match="no attribute 'tnue'"):
        hotlap.tnue  # noqa: B018


def test_importing_hotlap_loads_nothing():
    program = "import sys, hotlap; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split()
    assert {"numpy", "pydantic", "numba", "casadi"} & set(loaded) == set()
