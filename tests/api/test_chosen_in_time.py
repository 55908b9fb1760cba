"""The plan of a race that fixes none, chosen within some minutes: whatever takes time counts, and a search that goes on has what it had."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from fake_world import OPTIMUM, FakeWorld, make_scenario
from hotlap.api.chosen import PLANS, PlanChoice, minutes_beside, plan_of
from hotlap.api.progress import Quiet
from hotlap.core.records import End, Log
from hotlap.core.seeds import FLIGHTS_A_STREAM
from hotlap.race.race import PlanningSettings
from hotlap.study.configuration import Configuration
from hotlap.study.study import Study
from hotlap.tuning.goal import Metric
from hotlap.tuning.objective import Objective
from hotlap.tuning.settings import TuningSettings

MINUTE = TuningSettings(budget=FLIGHTS_A_STREAM, confirm=10, selection=2000, batch=32, minutes=1.0)
PLANNING, COMPILING, EACH = 8.0, 25.0, 0.01  # s


@dataclass
class Slow(FakeWorld):
    """No plan is held, or calm ones are; everything takes its time, by a clock of its own."""

    now: float = 0.0
    most: float = 0.0
    passed: int = 3  # gates, with plans that are not held; with fewer than half of them a plan is given up early
    compiled: list[float] = field(default_factory=list)

    def clock(self):
        return self.now

    def prepare(self, scenario):
        self.now += 0.0 if self.compiled else COMPILING
        self.compiled.append(scenario.race.thrust_share)

    def fly(self, scenario, parameters, seeds, *, vehicle_parameters=None, log=()):
        self.now += EACH * len(seeds)
        held = scenario.race.thrust_share <= self.most
        flights = FakeWorld(reach=0.0 if held else 1.0, noise=0.0).fly(scenario, parameters, seeds, vehicle_parameters=vehicle_parameters)
        if not held:
            flights = replace(flights, gates_passed=np.full(len(seeds), self.passed), end=np.full(len(seeds), int(End.MISSED)))
        return replace(flights, logs={i: Log(np.zeros(3), np.zeros((3, 13)), np.zeros((3, 4)), np.zeros((3, 4))) for i in log})


def configure(world, planning, race, settings):
    world.now += planning
    scenario = replace(make_scenario(), race=race)
    return Configuration(scenario, world.name, Metric.TIME, "random_search", settings, np.tile(1.1 * OPTIMUM, (2, 1)))


def choice_in(folder, world, settings=MINUTE, planning=PLANNING):
    race = make_scenario().race.model_copy(update={"planning": PlanningSettings()})
    asked = SimpleNamespace(hold="", progress=Quiet())
    return PlanChoice(race, world, settings, partial(configure, world, planning), folder, asked, clock=world.clock)


def finish(folder, world, configuration):
    """Go on with the study of the chosen plan, to its end."""
    with Study.open(folder, configuration) as study:
        return study.run(Objective(configuration.scenario, world), clock=world.clock)


@pytest.mark.check
@pytest.mark.parametrize("passed", [1, 3])
@pytest.mark.parametrize("planning", [0.5, PLANNING, 20.0])
def test_plans_compiling_and_search_together_take_the_minutes(tmp_path, planning, passed):
    world = Slow(passed=passed)
    choice = choice_in(tmp_path, world, planning=planning)
    chosen = choice.choose()
    assert chosen is not None
    result = finish(tmp_path, world, choice.settle(chosen))
    assert result.selection_flights > 0, "the result is chosen as that of any other search is"
    assert 45 < world.now < 60 + max(10.0, planning)


def test_planning_that_takes_longer_than_the_minutes_leaves_one_plan(tmp_path):
    world = Slow()
    choice = choice_in(tmp_path, world, planning=90.0)
    chosen = choice.choose()
    assert chosen is not None
    assert len(choice.plans) == 1
    assert finish(tmp_path, world, choice.settle(chosen)).validation is not None
    assert world.now < 90 + COMPILING + 20


def test_a_plan_that_holds_is_found_in_time(tmp_path):
    world = Slow(most=0.7)
    choice = choice_in(tmp_path, world, planning=2.0)
    chosen = choice.choose()
    assert chosen is not None
    assert chosen.holds
    assert world.now < 62


def test_a_search_that_goes_on_has_what_it_had_whatever_is_planned_and_compiled_anew(tmp_path):
    world = Slow()
    choice = choice_in(tmp_path, world)
    chosen = choice.choose()
    assert chosen is not None
    whole = choice.settle(chosen)
    _, plans, beside = plan_of(tmp_path)
    assert plans == tuple(choice.plans)
    assert minutes_beside(MINUTE, beside) == whole.settings.minutes, "the same command asks for the same"
    assert minutes_beside(replace(MINUTE, minutes=3.0), beside) == pytest.approx(2 + whole.settings.minutes)
    flown = finish(tmp_path, world, whole)
    assert finish(tmp_path, world, whole).flights == flown.flights, "its time is over"


def test_a_choice_that_goes_on_keeps_the_minutes_of_plans_that_were_begun(tmp_path):
    world = Slow()
    first = choice_in(tmp_path, world, planning=1.0)
    first._attempt(0.92)
    again = choice_in(tmp_path, world, planning=500.0)
    tried = again._attempt(0.92)
    assert tried == first.plans[0]
    with Study.read(tmp_path / PLANS / "0.92") as study:
        assert again.spent == 0.0
        assert again.time_left == pytest.approx(60 - study.wall_time, abs=5.0), "planning once more is not counted"


def test_what_is_compiled_after_a_study_is_opened_is_not_its_time(tmp_path):
    world = Slow()
    configuration = configure(world, 0.0, make_scenario().race, replace(MINUTE, minutes=0.2))
    with Study.open(tmp_path, configuration) as study:
        world.now += 1000.0
        result = study.run(Objective(configuration.scenario, world), clock=world.clock)
    assert result.wall_time < 15
