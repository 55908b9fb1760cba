"""Tuning in a simulator begins at home, flies as few flights as it can, and is gone on with in that simulator alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import hotlap
from fake_world import FakeWorld, make_scenario
from hotlap.api.given import as_annotated
from hotlap.api.progress import Quiet
from hotlap.core.errors import InputError
from hotlap.study.study import Study
from hotlap.tuners import build
from hotlap.tuning.loop import Tuning, TuningSettings, tune
from hotlap.tuning.objective import Objective
from worlds import own_simulator

OWN = "worlds.own_simulator.Own"


class Listening(Quiet):
    """Keeps what is said."""

    def __init__(self) -> None:
        self.said: list[str] = []

    def note(self, text: str) -> None:
        self.said.append(text)


def told(progress: Listening, words: str) -> list[str]:
    return [line for line in progress.said if words in line]


@pytest.mark.check
def test_it_begins_at_what_was_tuned_at_home_and_goes_on(tmp_path):
    own_simulator.OPENED.clear()
    first, again = Listening(), Listening()
    asked = {"budget": 30, "out": tmp_path / "study", "on": f"{OWN}:3", "instances": 2, "confirm": 3}
    tuned = hotlap.tune("circle-34", **asked, progress=first)
    assert tuned.confirmed
    assert tuned.world == f"{OWN}:3"
    assert tuned.validation.flights == 20
    assert tuned.robustness == ()
    assert tuned.report.is_file()
    assert len(told(first, "tuned in the built-in world first")) == 1
    assert len(told(first, "validated by 20 flights")) == 1
    with Study.read(tmp_path / "study") as study, Study.read(tmp_path / "study" / "home") as home:
        assert home.configuration.world == "built-in"
        assert study.configuration.settings.batch == 6
        np.testing.assert_array_equal(study.configuration.first_guess, home.result.best.parameters)
    once_more = hotlap.tune("circle-34", **{**asked, "instances": 1}, progress=again)
    np.testing.assert_array_equal(once_more.values, tuned.values)
    assert once_more.result.flights == tuned.result.flights
    assert told(again, "tuned in the built-in world first") == []
    with pytest.raises(InputError, match="world: this study has"):
        hotlap.tune("circle-34", **{**asked, "on": OWN})


@pytest.mark.check
def test_a_first_guess_that_is_asked_for_is_begun_with(tmp_path):
    listening = Listening()
    asked = {"budget": 1, "validation": 2, "selection": 0, "on": OWN, "first_guess": "paper"}
    tuned = hotlap.tune("circle-34", **asked, out=tmp_path, progress=listening)
    assert tuned.first_guess == "paper"
    assert tuned.validation.flights == 2
    assert not (tmp_path / "home").exists()
    assert told(listening, "take their time") == []


@pytest.mark.parametrize("call", [hotlap.tune, hotlap.fly])
def test_conditions_are_refused_where_the_vehicle_cannot_be_changed(call):
    with pytest.raises(InputError, match=r"hold: worlds\.own_simulator\.Own flies the vehicle that it has"):
        call("circle-34", on=OWN, hold="mass=+-10%")


def test_a_simulator_that_cannot_be_opened_is_known_before_anything_is_tuned(tmp_path):
    with pytest.raises(InputError, match="on: there is no such drone"):
        hotlap.tune("circle-34", on="worlds.own_simulator.cannot_open", out=tmp_path)
    assert not (tmp_path / "home").exists()


def test_reflights_flown_a_few_at_a_time_tell_the_same_and_take_fewer_flights():
    """What is counted is the same, however many are flown together."""
    runs = []
    for together in (0, 1, 3):
        world, scenario = FakeWorld(noise=0.9), make_scenario()
        settings = TuningSettings(budget=120, confirm=6, validation=0, batch=2)
        tuning = Tuning(build("random_search"), scenario, settings)
        tuning.together = together
        batches = list(tune(Objective(scenario, world), tuning))
        runs.append((batches[-1].flights, batches[-1].best.cost, sum(world.batches)))
    (flights, cost, together), one_by_one, by_three = runs
    assert (flights, cost) == one_by_one[:2] == by_three[:2]
    assert one_by_one[2] < by_three[2] < together
    assert one_by_one[2] == flights


def test_a_path_stands_for_its_text():
    given = as_annotated(hotlap.tune, {"race": Path("my-race.toml"), "first_guess": Path("runs") / "mine"})
    assert given["first_guess"] == str(Path("runs") / "mine")
