"""A search whose time is counted ends in time, with a result that was chosen and validated."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace

import numpy as np
import pytest

from fake_world import OPTIMUM, FakeWorld, make_scenario
from hotlap import tuners
from hotlap.core.seeds import FLIGHTS_A_STREAM
from hotlap.tuners import Tuner
from hotlap.tuners.contest import Contest
from hotlap.tuners.random_search import PRESETS, RandomSearch
from hotlap.tuning.loop import Tuning, tune
from hotlap.tuning.objective import Objective
from hotlap.tuning.settings import TuningSettings
from hotlap.tuning.timekeeper import Timekeeper

SCENARIO = make_scenario()
GUESS = np.tile(1.1 * OPTIMUM, (2, 1))
SECONDS = 15.0
SHORT = TuningSettings(budget=FLIGHTS_A_STREAM, confirm=10, selection=2000, batch=32, minutes=0.25)


@dataclass
class Clock:
    """Says how late it is: so long after each flight, and so long as a tuner has thought."""

    seconds: float
    world: FakeWorld
    tuner: Tuner

    def __call__(self) -> float:
        return self.seconds * sum(self.world.batches) + getattr(self.tuner, "thought", 0.0)


class Thoughtful(RandomSearch):
    """Thinks a second about each proposal, and has but one."""

    thought = 0.0

    def ask(self, n: int) -> np.ndarray:  # noqa: ARG002
        self.thought += 1.0
        return super().ask(1)


def play(settings: TuningSettings = SHORT, noise: float = 1.2, each: float = 0.02, spent: float = 0.0, state=None, tuner=None):
    world, tuner = FakeWorld(noise=noise), tuner or tuners.build("gate_gp")
    tuning, batches = Tuning(tuner, SCENARIO, settings, GUESS, state), []
    keeper = Timekeeper(tuning, Objective(SCENARIO, world), spent, Clock(each, world, tuner))
    for batch in tune(keeper, tuning):
        batches.append(batch)
        keeper.attend()
    return tuning, batches, keeper, world


@pytest.mark.parametrize("each", [0.01, 0.02])
def test_a_run_of_some_seconds_ends_in_time_with_a_result_that_was_chosen_and_validated(each):
    tuning, _, keeper, _ = play(each=each)
    assert -2 * 32 * each <= keeper.left < 0.5 * SECONDS
    assert tuning.done
    assert tuning.selection_flights * each < 0.4 * SECONDS
    assert tuning.selection_flights > 30
    assert tuning.validation is not None


def test_a_good_controller_ends_it_before_the_time_is_over():
    tuning, _, keeper, _ = play(noise=0.3, each=0.01)
    assert keeper.left > 0.3 * SECONDS
    assert tuning.best is not None
    assert tuning.best.confirmed
    assert tuning.validation is not None
    assert tuning.validation.rate > 0.95


@pytest.mark.parametrize("name", ["gate_gp", "cma_es", "guided_walk:tied"])
def test_populations_are_flown_at_once(name):
    _, _, _, world = play(tuner=tuners.build(name))
    assert max(world.batches[:5]) >= 8


def test_of_two_guesses_the_search_goes_on_in_populations():
    tuning, *_ = play(tuner=Contest(tuners.build("gate_gp"), np.tile(OPTIMUM, (2, 1))))
    assert tuning.done
    assert tuning.selection_flights > 30


def test_an_interrupted_search_goes_on_with_what_is_left_of_it():
    _, whole, keeper, _ = play(each=0.01)
    state = json.loads(json.dumps(whole[4].state, allow_nan=False))
    tuning, after, rest, _ = play(state=state, spent=0.7 * SECONDS, each=0.01)
    assert after[0].state == whole[5].state
    assert rest.left < 0.5 * SECONDS
    assert tuning.done
    assert tuning.flights < whole[-1].flights
    late, after, _, _ = play(state=state, spent=SECONDS + 1)
    assert late.done
    assert late.flights == whole[4].flights, "the time was over"
    assert late.selection_flights > 0
    assert keeper.left < 0.5 * SECONDS


def test_a_finished_search_flies_nothing_and_one_with_more_time_goes_on():
    tuning, batches, _, _ = play()
    state = json.loads(json.dumps(batches[-1].state, allow_nan=False))
    assert not play(state=state, spent=SECONDS + 10)[1]
    longer, after, _, _ = play(replace(SHORT, minutes=0.5), state=state, spent=SECONDS)
    assert after
    assert longer.flights > tuning.flights
    assert longer.done


def test_a_tuner_that_thinks_long_has_the_time_that_flights_leave():
    tuning, _, keeper, _ = play(tuner=Thoughtful("thoughtful", PRESETS["paper"]), each=0.001)
    assert tuning.done
    assert -1.5 < keeper.left < 0.2 * SECONDS


def test_a_budget_that_is_spent_first_leaves_time_as_well():
    tuning, _, keeper, _ = play(replace(SHORT, budget=60), each=0.02)
    assert tuning.done
    assert 0 < tuning.selection_flights * 0.02 <= 0.3 * SECONDS
    assert keeper.left > 0.3 * SECONDS


def test_without_minutes_no_time_is_kept():
    asked = TuningSettings(budget=30, validation=10)
    tuning, batches, _, world = play(asked, each=1e6)
    assert tuning.flights == 30
    assert max(world.batches[:-1]) <= 4
    assert not batches[-1].state["ended"]
