"""Every controller of the registry takes its tuned parameters in units of its own, by their names."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from hotlap.flight.fly import prepare
from hotlap.flight.numbers import Numbers
from hotlap.flight.registry import CONTROLLERS
from hotlap.race.controller_kind import kind_and_solver
from hotlap.race.controllers import TUNABLE, ControllerKind
from hotlap.reference.scenario import Scenario

from .scenarios import make_scenario

EVERY = pytest.mark.parametrize("kind", ControllerKind)


def flown_by(kind: ControllerKind) -> Scenario:
    scenario = make_scenario()
    return replace(scenario, race=scenario.race.with_controller(kind))


def draw(scenario: Scenario) -> np.ndarray:
    """Parameters of three flights that all differ."""
    return scenario.space.default * np.random.default_rng(0).uniform(0.5, 2.0, (3, len(scenario.segments), scenario.space.size))


def test_every_kind_has_its_functions():
    assert set(CONTROLLERS) >= set(ControllerKind) == set(TUNABLE)
    assert {kind_and_solver(law)[0] for law in CONTROLLERS} == set(ControllerKind)


@EVERY
def test_what_is_tuned_stays_as_it_is_and_compiled_code_gets_one_kind_of_array(kind):
    scenario = flown_by(kind)
    tuned = draw(scenario)
    for given in (tuned, np.asfortranarray(tuned), np.broadcast_to(tuned[:1], tuned.shape)):
        before = given.copy()
        taken = CONTROLLERS[kind].parameters_of(scenario.race.controller, given)
        assert_array_equal(given, before)
        assert (taken.shape, taken.dtype, taken.flags.c_contiguous) == (given.shape, np.float64, True)


@EVERY
def test_a_horizon_becomes_the_time_between_nodes_and_all_else_stays(kind):
    scenario = flown_by(kind)
    tuned, names, settings = draw(scenario), TUNABLE[kind].names, scenario.race.controller
    taken = prepare(scenario, tuned, np.arange(3), Numbers.FLOAT64, None, ())[0].parameters
    for k, name in enumerate(names):
        unit = settings.horizon_unit / settings.nodes if name == "horizon" else 1.0
        assert_array_equal(taken[..., k], tuned[..., k] * unit)
