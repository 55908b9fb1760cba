"""What flights with untuned weights say: in a world whose flights are a formula."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from fake_world import FakeWorld, make_scenario
from hotlap.api.first_flights import describe_flights, find_doom, fly_untuned, say_doom
from hotlap.core.records import End
from hotlap.feasibility.finding import Level

FLIGHTS = 20
SKILLS = {"easy": 0.1, "moderate": 2.2, "hard": 2.8}


@dataclass
class Deadly(FakeWorld):
    """Every flight ends by a crash before its first gate."""

    after: float = 0.05

    def fly(self, scenario, parameters, seeds, *, vehicle_parameters=None, log=()):
        flights, none = super().fly(scenario, parameters, seeds, vehicle_parameters=vehicle_parameters, log=log), np.zeros(len(seeds), int)
        ended, never = np.full(len(seeds), self.after), np.full(len(seeds), np.nan)
        return replace(flights, gates_passed=none, end=np.full(len(seeds), int(End.CRASHED)), end_time=ended, lap_time=never)


@dataclass
class Blind(FakeWorld):
    """No flight passes its first gate."""

    def fly(self, scenario, parameters, seeds, *, vehicle_parameters=None, log=()):
        flights = super().fly(scenario, parameters, seeds, vehicle_parameters=vehicle_parameters, log=log)
        return replace(flights, gates_passed=np.zeros(len(seeds), int), end=np.full(len(seeds), int(End.MISSED)))


@dataclass
class Knowing(FakeWorld):
    """All is well as soon as the dead time is known, or the plan is slow."""

    def fly(self, scenario, parameters, seeds, *, vehicle_parameters=None, log=()):
        race = scenario.race
        well = race.control_model.delay == race.vehicle.delay and race.thrust_share < 0.7
        return FakeWorld(reach=0.0 if well else 2.8).fly(scenario, parameters, seeds, vehicle_parameters=vehicle_parameters, log=log)


def findings(world, scenario=None, slower=None):
    return {finding.label: finding for finding in describe_flights(scenario or make_scenario(), world, FLIGHTS, slower)}


@pytest.mark.parametrize("word", SKILLS)
def test_a_race_is_called_what_its_flights_are(word):
    assert findings(FakeWorld(reach=SKILLS[word]))["difficulty"].value == word


def test_how_many_are_complete_and_how_the_others_end_is_counted():
    world = FakeWorld()
    (default, *_), found = fly_untuned(make_scenario(), world, FLIGHTS), findings(world)["default weights"]
    assert found.value == f"{default.flown.complete.successes} of {FLIGHTS} flights complete"
    ends = [int(part.split()[0]) for part in found.remark.split(", ")]
    assert sum(ends) == FLIGHTS - default.flown.complete.successes > 0


def test_flights_that_are_over_at_once_are_beyond_all_weights_and_nothing_is_advised():
    found = findings(Deadly(), slower=lambda _: make_scenario())
    assert (found["random weights"].level, found["difficulty"].value) == (Level.WARNING, "beyond all weights")
    assert "all within 0.1 s" in found["random weights"].remark
    assert (found["dead at once"].value, found["dead at once"].level) == (f"{FLIGHTS} of {FLIGHTS} flights", Level.WARNING)
    assert not any(label.startswith("with") for label in found)
    later = findings(Deadly(after=0.4))
    assert "within" not in later["random weights"].remark
    assert "dead at once" not in later


def test_a_tuning_is_told_before_it_begins_where_no_weights_pass_the_first_gate():
    scenario, hard = make_scenario(), FakeWorld(reach=2.8)
    weights = scenario.space.first_guess(2)
    assert find_doom(scenario, hard, fly_untuned(scenario, hard, FLIGHTS)) is None
    assert say_doom(scenario, hard, weights) == ""
    missed = "of 64 weights drawn at random none passes gate 1"
    assert say_doom(scenario, Blind(), weights) == f"{missed} (64 missed gate 1)"
    assert say_doom(scenario, Deadly(), weights).startswith(f"no weights help as it stands: {missed} (64 crashed before gate 1")


def test_weights_that_miss_the_first_gate_leave_hope():
    found = findings(Blind())
    assert (found["random weights"].level, found["difficulty"].value) == (Level.WARNING, "hard")


def with_race(scenario, **changes):
    return replace(scenario, race=scenario.race.model_copy(update=changes))


def test_a_dead_time_that_explains_the_failures_is_said_with_its_cure():
    scenario = make_scenario()
    slow, late = scenario.race.planning.model_copy(update={"thrust_share": 0.5}), scenario.race.vehicle.model_copy(update={"delay": 0.04})
    found = findings(Knowing(), with_race(scenario, vehicle=late, model=scenario.race.vehicle, planning=slow))
    assert found["with its dead time known"].remark == "set model.delay = 0.04"
    assert found["with its dead time known"].value == f"{FLIGHTS} of {FLIGHTS} flights complete"
    assert "without noise" not in found


def test_a_slower_plan_is_advised_where_its_flights_are_better():
    straight = make_scenario()
    strong = straight.race.vehicle.model_copy(update={"rotor_thrust": (0.0, 10.0)})
    scenario = with_race(straight, vehicle=strong, controller=straight.race.controller.model_copy(update={"thrust": (0.1, 50.0)}))
    found = findings(Knowing(), scenario, lambda race: replace(scenario, race=race))["with a slower plan"]
    share = float(found.remark.split(" = ")[1].split(":")[0])
    assert share < scenario.race.thrust_share
    assert "with a slower plan" not in findings(FakeWorld(reach=2.8), scenario, lambda race: replace(scenario, race=race))
    assert "with a slower plan" not in findings(Knowing(), scenario, None)
