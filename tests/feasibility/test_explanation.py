"""What a margin means, and what would leave enough thrust."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flight.scenarios import make_race, make_reference
from hotlap.feasibility.explanation import describe_margins, explain, help_with, share_with_margin
from hotlap.feasibility.finding import Level
from hotlap.feasibility.margins import ENOUGH, margin, margins
from hotlap.planning import plan
from hotlap.race.hold import parse_hold
from planning import small

REFERENCE = make_reference()


def test_where_no_slower_plan_could_hover_none_is_named():
    race = make_race(controller={"thrust": (0.1, 12.0)}, vehicle={"rotor_thrust": (0.0, 12.0 * 0.716 / 4)})
    said = explain(race, REFERENCE, margin(race, REFERENCE), planned=False)
    assert said.endswith("; take stronger rotors: no slower plan leaves enough thrust")
    assert "takes at most" not in said


def test_words_say_that_nothing_helps_or_that_hardly_any_is_left_or_nothing():
    race = make_race(controller={"thrust": (0.1, 16.0)})
    said = [explain(race, REFERENCE, margin(race, REFERENCE, *parse_hold(hold)), planned=False) for hold in ("mass=+30%", "mass=+10%", "")]
    assert "0.88 of the thrust" in said[0]
    assert "no weights will help; set controller.thrust = [0.1, 19], which the rotors have" in said[0]
    assert "hardly any" in said[1]
    assert said[2] == ""


@pytest.mark.check
def test_the_share_that_is_named_leaves_enough_as_planned():
    race = small.FULL["at once"]
    planning = race.planning.model_copy(update={"quadrotor": None, "thrust_share": 0.6})
    race = race.model_copy(update={"planning": planning, "controller": race.controller.model_copy(update={"thrust": (0.1, 33.0)})})
    heavier = parse_hold("mass=+60%")
    reference = plan(race)
    found = margin(race, reference, *heavier)
    share = share_with_margin(race, found)
    assert found.thrust < ENOUGH
    assert share is not None
    slower = race.model_copy(update={"planning": planning.model_copy(update={"thrust_share": share})})
    assert margin(slower, plan(slower), *heavier).reserve == pytest.approx(ENOUGH, rel=0.03)


@pytest.mark.parametrize(
    ("rotor", "planned", "verb"), [(6.0, False, "set"), (3.3, True, "set"), (1.0, True, "take"), (2.6, False, "fly"), (1.0, False, "take")]
)
def test_what_is_told_to_do_has_a_verb_and_what_it_changes_has_none(rotor, planned, verb):
    rotors = {"rotor_thrust": (0.0, rotor)}
    race = make_race(vehicle=rotors, model=rotors, controller={"thrust": (0.1, 4 * min(rotor, 3.3) / 0.716)})
    race = race.model_copy(update={"planning": race.planning.model_copy(update={"quadrotor": None, "thrust_share": 0.9})})
    helps = help_with(race, REFERENCE, margin(race, REFERENCE, *parse_hold("mass=+10%")), planned=planned)
    assert helps.advice.startswith(f"{verb} ")
    assert helps.change.split()[0] not in {"set", "take", "fly", "no"}
    assert verb == "take" or helps.advice.startswith(f"{verb} {helps.change}")


def test_a_race_that_plans_by_no_share_names_none():
    race = make_race()
    assert race.planning.quadrotor is not None
    assert share_with_margin(race, margin(race, REFERENCE)) is None


def test_check_notes_conditions_without_enough_thrust_and_rates_that_are_not_there():
    race = make_race(controller={"thrust": (0.1, 15.5)})
    found = {finding.label: finding for finding in describe_margins(race, REFERENCE, margins(race, REFERENCE), planned=False)}
    assert found["thrust left"].level is Level.FACT
    assert found["- 10 % heavier"].level is found["- 15 % less thrust"].level is Level.NOTE
    assert "- 10 % lighter" not in found
    quick = replace(REFERENCE, rates=20 * REFERENCE.rates)
    rates = [one for one in describe_margins(race, quick, margins(race, quick)) if one.label == "rates left"]
    assert rates[0].level is Level.NOTE
    assert "raise controller.rates" in rates[0].remark
