"""Whether a controller is offset-free, where its race leaves it open: if the plan leaves thrust for it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flight.scenarios import make_scenario
from hotlap.files.descriptions import load_race, names
from hotlap.files.kinds import Kind
from hotlap.race.controller_kind import ControllerKind
from hotlap.reference.scenario import COMMANDED, Scenario

PAPER = (
    "circle-20",
    "circle-34",
    "drop-20",
    "final-22",
    "flip-16",
    "qualifier-20",
    "soccer-medium-20",
    "spiral-53",
    "spiral20-53",
    "split-s",
)


def scenario_of(margin: float, asked: bool | None, kind: ControllerKind = ControllerKind.MPC, thrust: float = 1e3) -> Scenario:
    """The small race with a plan that leaves a margin of thrust, flown by a controller that is asked to be offset-free, or not."""
    scenario = make_scenario(controller={"offset_free": asked, "thrust": (0.1, thrust)})
    scenario = replace(scenario, race=scenario.race.with_controller(kind))
    most = min(thrust, COMMANDED * scenario.race.control_model.max_acceleration)
    plan, before = scenario.reference, scenario.reference.thrust[: scenario.reference.planned_rows].max()
    return replace(scenario, reference=replace(plan, thrust=plan.thrust * (most / margin / before)))


@pytest.mark.parametrize("kind", ControllerKind)
@pytest.mark.parametrize("thrust", [12.0, 1e3], ids=["controller", "rotors"])
@pytest.mark.parametrize(("margin", "on"), [(0.9, False), (0.999, False), (1.001, True), (1.2, True)])
def test_where_nothing_is_said_the_margin_of_thrust_decides(margin, on, thrust, kind):
    scenario = scenario_of(margin, None, kind, thrust)
    assert scenario.thrust_margin == pytest.approx(margin)
    assert scenario.offset_free is on


@pytest.mark.parametrize("asked", [True, False])
@pytest.mark.parametrize("margin", [0.8, 1.5])
def test_what_is_said_is_respected(margin, asked):
    assert scenario_of(margin, asked).offset_free is asked


def test_what_the_reference_asks_for_behind_its_plan_does_not_count():
    scenario = scenario_of(1.1, None)
    thrust = scenario.reference.thrust.copy()
    planned = scenario.reference.planned_rows
    assert planned < len(thrust)
    thrust[planned:] *= 2
    assert replace(scenario, reference=replace(scenario.reference, thrust=thrust)).offset_free


@pytest.mark.parametrize("name", names(Kind.RACE))
def test_races_that_reproduce_the_paper_say_that_it_is_off_and_others_say_nothing(name):
    off = name in PAPER or name.startswith("airsim-")
    assert load_race(name).controller.offset_free is (False if off else None)


@pytest.mark.parametrize("name", PAPER)
def test_a_race_that_reproduces_the_paper_is_off_with_all_the_thrust_there_is(name):
    scenario = scenario_of(3.0, None)
    race = load_race(name).model_copy(update={"track": scenario.race.track})
    assert not replace(scenario, race=race).offset_free


def test_a_users_own_race_leaves_it_open(tmp_path):
    (tmp_path / "mine.toml").write_text('track = "circle"\nvehicle = "hummingbird"\n', encoding="utf-8")
    assert load_race(tmp_path / "mine.toml").controller.offset_free is None
    for said, value in (("true", True), ("false", False)):
        text = f'track = "circle"\nvehicle = "hummingbird"\n[controller]\noffset_free = {said}\n'
        (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
        assert load_race(tmp_path / "mine.toml").controller.offset_free is value
