"""A race is made ready, and parameters fit it or are refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fake_world import make_scenario
from hotlap.core.errors import InputError
from hotlap.files.descriptions import save
from hotlap.files.parameters_file import SavedParameters
from hotlap.planning.preparation import differences, parameters_for, prepare
from hotlap.reference.segmentation import SegmentationRule, SegmentClass, Segments, segment
from hotlap.reference_files.csv import save_reference

SCENARIO = make_scenario()


def saved(**changes) -> SavedParameters:
    values = np.arange(1.0, 11.0).reshape(2, 5) * [1, 100, 1, 1, 0.4] + [0, 0, 0, 0, 1]
    return replace(SavedParameters("straight", SCENARIO.space.names, SCENARIO.segments, values), **changes)


def test_a_race_with_a_reference_is_ready_without_planning(tmp_path, monkeypatch):
    monkeypatch.setattr("hotlap.planning.preparation.plan", lambda *_: pytest.fail("planned"))
    save(tmp_path / "straight.toml", SCENARIO.race)
    save_reference(tmp_path / "plan.csv", SCENARIO.reference)
    for race in (SCENARIO.race, tmp_path / "straight.toml", str(tmp_path / "straight.toml")):
        scenario = prepare(race, tmp_path / "plan.csv")
        assert scenario.race == SCENARIO.race
        np.testing.assert_allclose(scenario.reference.gate_times, SCENARIO.reference.gate_times, atol=0.02)
        assert scenario.segments.duration == scenario.reference.duration


def test_a_race_is_planned_and_segmented(monkeypatch):
    asked = []
    monkeypatch.setattr("hotlap.planning.preparation.plan", lambda race, cache: asked.append((race.name, cache)) or SCENARIO.reference)
    scenario = prepare("circle-34", cache=False)
    assert asked == [("circle-34", False)]
    assert scenario.reference is SCENARIO.reference


def test_parameters_fit_in_any_order_of_names():
    names = tuple(reversed(SCENARIO.space.names))
    turned = saved(names=names, values=saved().values[:, ::-1])
    np.testing.assert_array_equal(parameters_for(SCENARIO, turned, "x"), saved().values)
    assert differences(SCENARIO, turned) == ()


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
        parameters_for(SCENARIO, saved(**changes), "f")


def test_what_differs_but_fits_is_said():
    other = saved(race="loop", segments=replace(SCENARIO.segments, classes=(SegmentClass.STEEP, SegmentClass.FLAT)))
    assert differences(SCENARIO, other) == (
        "tuned for loop, used for straight",
        "tuned for segments steep, flat, used for flat, ascent",
    )


def test_segments_that_are_other_parts_of_the_same_flight_are_said():
    halves = replace(SCENARIO.segments, starts=np.array([0.0, 2.55]))
    assert differences(SCENARIO, saved(segments=halves)) == ()
    others = replace(SCENARIO.segments, starts=np.array([0.0, 3.3]))
    assert differences(SCENARIO, saved(segments=others)) == ("tuned for segments that begin at 0.0, 3.3 s, used for 0.0, 2.5 s",)
    shared = Segments(np.array([0.0, 2.5, 4.0]), (*SCENARIO.segments.classes, SegmentClass.FLAT), 5.0, (0, 1, 0))
    assert differences(SCENARIO, saved(segments=shared)) == ("tuned for segments that begin at 0.0, 2.5, 4.0 s, used for 0.0, 2.5 s",)


@pytest.mark.parametrize("rule", list(SegmentationRule))
def test_a_race_is_cut_by_the_rule_that_is_asked_for(monkeypatch, rule):
    monkeypatch.setattr("hotlap.planning.preparation.plan", lambda *_, **__: SCENARIO.reference)
    segments, wanted = prepare(SCENARIO.race, segments=rule).segments, segment(SCENARIO.reference, rule)
    assert segments.starts.tolist() == wanted.starts.tolist()
    assert segments.classes == wanted.classes
