"""The plan of a race that fixes none, chosen by tuning."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest

import hotlap
from fake_world import FakeWorld, make_scenario
from hotlap import worlds
from hotlap.api.progress import Quiet
from hotlap.core.records import End, Log
from hotlap.files.descriptions import load_parameters, load_race, save
from hotlap.race.race import PlanningSettings
from hotlap.study.study import Study

tune = partial(hotlap.tune, tuner="random_search")  # it does not think between flights


@dataclass
class Holding(FakeWorld):
    """All flights pass all gates with plans up to a share of the thrust, and bolder ones miss the first."""

    most: float = 0.8
    flown: int = 0

    def fly(self, scenario, parameters, seeds, *, vehicle_parameters=None, log=()):
        calm = scenario.race.thrust_share <= self.most
        flights = FakeWorld(reach=0.0, noise=0.0).fly(scenario, parameters, seeds, vehicle_parameters=vehicle_parameters)
        self.flown += len(seeds)
        if not calm:
            flights = replace(flights, gates_passed=np.zeros(len(seeds), int), end=np.full(len(seeds), int(End.MISSED)))
        steps = np.zeros(3)
        return replace(flights, logs={i: Log(steps, np.zeros((3, 13)), np.zeros((3, 4)), np.zeros((3, 4))) for i in log})


@pytest.fixture
def world(here, monkeypatch):
    """The race of open.toml, which fixes no plan, is flown in a world that holds 80 % of the thrust."""
    race = make_scenario().race
    save(here / "open.toml", race.model_copy(update={"planning": PlanningSettings(), "name": "open"}))
    made = Holding()
    monkeypatch.setattr(worlds, "build", lambda *_: made)
    return made


@pytest.fixture(autouse=True)
def no_page(monkeypatch, request):
    """Pages take their time, and one test looks at one."""
    if "page" not in request.node.name:
        monkeypatch.setattr("hotlap.api.tuned._report", lambda *_: ((), None, {}))


@pytest.mark.usefixtures("world")
def test_the_page_says_which_plan_was_chosen_and_why():
    page = tune("open.toml", out="mine").report
    assert page is not None
    assert "planned with 75 % of the thrust: 5.00 s; at 85 % 50 of 50 flights missed gate 1" in page.read_text(encoding="utf-8")


@pytest.mark.usefixtures("world")
def test_the_boldest_plan_that_holds_is_tuned_and_the_study_says_so(here):
    tuned = tune("open.toml", out="mine")
    assert tuned.confirmed
    assert [(plan.share, plan.holds) for plan in tuned.plans] == [(0.92, False), (0.85, False), (0.65, True), (0.75, True)]
    assert tuned.scenario.race.planning.thrust_share == 0.75
    assert tuned.plans[0].end == "50 of 50 flights missed gate 1"
    assert tuned.to_dict()["plans"][-1]["share"] == 0.75
    with Study.read(here / "mine") as study:
        assert study.configuration.scenario.race.planning.thrust_share == 0.75
        assert tuple(study.plans) == tuned.plans
    assert sorted(path.name for path in (here / "mine" / "plans").iterdir()) == ["0.65", "0.85", "0.92"], "the others can be looked at"


def test_all_plans_together_fly_no_more_than_the_budget(world):
    world.most = 0.0
    tuned = tune("open.toml", out="mine", budget=100)
    assert not tuned.confirmed
    with Study.read("mine") as study:
        others = sum(plan.flights for plan in tuned.plans if plan.share != tuned.scenario.race.planning.thrust_share)
        assert others + study.tuning.flights <= 100


def test_the_same_command_goes_on_with_the_plan_that_was_chosen(world):
    first = tune("open.toml", out="mine")
    before = world.flown
    world.most = 0.0
    again = tune("open.toml", out="mine")
    assert again.plans == first.plans
    assert again.scenario.race.planning.thrust_share == 0.75
    with Study.read("mine") as study:
        assert study.tuning.flights == first.result.flights
    assert world.flown == before


class Stopping(Quiet):
    """Stops a tuning after so many batches."""

    def __init__(self, batches: int) -> None:
        self.left = batches

    def flights(self, *_):
        def watch(_):
            self.left -= 1
            if self.left == 0:
                raise KeyboardInterrupt

        return nullcontext(watch)


@pytest.mark.usefixtures("world")
@pytest.mark.parametrize("batches", [1, 3, 5])
def test_a_choice_that_was_stopped_goes_on_and_ends_the_same(batches):
    whole = tune("open.toml", out="whole")
    with pytest.raises(KeyboardInterrupt) as stopped:
        tune("open.toml", out="parts", progress=Stopping(batches))
    assert "out='parts')" in "".join(stopped.value.__notes__)
    parts = tune("open.toml", out="parts")
    assert parts.plans == whole.plans
    np.testing.assert_array_equal(parts.values, whole.values)


@pytest.mark.usefixtures("world")
def test_parameters_are_flown_with_the_plan_that_they_were_tuned_on():
    tune("open.toml", out="mine")
    assert load_parameters("mine").provenance["thrust_share"] == 0.75
    assert hotlap.fly("open.toml", parameters="mine", flights=5).scenario.race.planning.thrust_share == 0.75
    assert hotlap.fly("open.toml", flights=5).scenario.race.thrust_share == 0.85
    other = load_race("open.toml").model_copy(update={"name": "other"})
    assert hotlap.fly(other, parameters="mine", flights=5).scenario.race.planning.free, "another race's plan is not its own"


@pytest.mark.usefixtures("world")
def test_a_plan_that_the_race_fixes_is_tuned_as_it_is():
    race = load_race("open.toml")
    assert tune(race.with_share(0.9), out="mine", budget=40).plans == ()
    assert tune(race, out="two", budget=10).plans == (), "too few flights to choose by"
    assert tune(race, out="three", goal="none", budget=40).plans == (), "nothing tells which plan holds"
