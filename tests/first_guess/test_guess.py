"""Where a search begins, by name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fake_world import make_scenario
from first_guess.small import DEFAULT, GOOD, NAMES, make_race, make_set
from hotlap.core.errors import UnknownNameError
from hotlap.first_guess.guess import DEFAULT as AUTHORS
from hotlap.first_guess.guess import NAMES as GUESSES
from hotlap.first_guess.guess import first_guess
from hotlap.race.controllers import ControllerKind

SCENARIO, TRAINING = make_scenario(), make_set(make_race("a", "080"))


def controlled(**changes):
    settings = SCENARIO.race.controller.model_copy(update=changes)
    return replace(SCENARIO, race=SCENARIO.race.model_copy(update={"controller": settings}))


@pytest.mark.parametrize("name", [name for name in GUESSES if name != AUTHORS])
def test_it_is_learnt_for_every_segment(name):
    np.testing.assert_allclose(first_guess(SCENARIO, name, TRAINING), [GOOD, GOOD], rtol=1e-9)


def test_the_default_is_the_authors():
    assert first_guess(SCENARIO, AUTHORS, TRAINING).tolist() == [list(DEFAULT)] * 2


@pytest.mark.parametrize("name", [name for name in GUESSES if name != AUTHORS])
def test_it_knows_other_units_of_the_horizon_and_keeps_to_the_bounds(name):
    guess = first_guess(controlled(horizon_unit=1.0, low=(1.0, 350.0, 1.0, 1.0, 1.0)), name, TRAINING)
    np.testing.assert_allclose(guess[0], [40.0, 350.0, 30.0, 7.0, 2.5], rtol=1e-9)


def test_nothing_is_learnt_about_other_controllers():
    scenario = replace(SCENARIO, race=SCENARIO.race.with_controller(ControllerKind.GEOMETRIC))
    assert scenario.space.names != NAMES
    assert first_guess(scenario, training=TRAINING).tolist() == scenario.space.first_guess(2).tolist()


def test_an_unknown_name_is_said_with_those_that_are_known():
    with pytest.raises(
        UnknownNameError, match=r"no first guess named 'learnt' \(did you mean learned\?\); available: default, learned, paper"
    ):
        first_guess(SCENARIO, "learnt", TRAINING)
