"""Worlds by name."""

from __future__ import annotations

import numpy as np
import pytest

from flight.scenarios import make_scenario, parameters
from hotlap import worlds
from hotlap.core.errors import InputError, UnknownNameError
from hotlap.worlds.stepped import Stepped
from hotlap.worlds.world import is_slow
from worlds import own_simulator

OWN = "worlds.own_simulator.Own"


def test_the_built_in_world_is_the_first_and_not_slow():
    assert worlds.names()[0] == worlds.DEFAULT == worlds.build("built-in").name
    assert not is_slow(worlds.build("built-in"))


@pytest.mark.parametrize("name", worlds.names()[1:])
def test_a_simulator_is_opened_by_its_first_flight_and_not_before(name):
    world = worlds.build(f"{name}:told")
    assert isinstance(world, Stepped)
    assert world.name == f"{name}:told"


def test_a_simulator_of_ones_own_is_told_its_number_and_what_stands_behind_the_colon():
    own_simulator.OPENED.clear()
    world = worlds.build(f"{OWN}:2", instances=2)
    assert is_slow(world)
    assert own_simulator.OPENED == []
    world.fly(make_scenario(), parameters(6), np.arange(6))
    assert sorted(own_simulator.OPENED) == [(0, "2"), (1, "2")]
    world.fly(make_scenario(), parameters(6), np.arange(6))
    assert len(own_simulator.OPENED) == 2
    world.fly(make_scenario({"mass": 0.8}), parameters(1), np.arange(1))
    assert own_simulator.OPENED[2:] == [(0, "2")]
    assert worlds.build(OWN).name == OWN


def test_an_unknown_world_is_refused_with_those_there_are():
    with pytest.raises(UnknownNameError, match=r"on: there is no world named 'moon'; available: .*built-in.*, my_module.MySimulator"):
        worlds.build("moon")


@pytest.mark.parametrize(
    ("name", "instances", "reason"),
    [
        ("worlds.own_simulator.Other", 1, "on: worlds.own_simulator.Other cannot be imported: .*no attribute 'Other'"),
        ("no_such_module.Own", 1, "on: no_such_module.Own cannot be imported: No module named 'no_such_module'"),
        ("worlds.own_simulator.NUMBER", 1, "cannot be imported: it is no class"),
        ("mavlink:udpin:127.0.0.1:1", 1, "on: mavlink is no world but a real vehicle, which is flown once: hotlap.lap"),
        ("built-in:fast", 1, "on: built-in is told nothing, not 'fast'"),
        ("built-in", 2, "instances: are of simulators; built-in flies on all processors at once"),
        (OWN, 0, "instances: must be from 1 to 256, not 0"),
    ],
)
def test_what_is_no_world_is_refused_in_one_line(name, instances, reason):
    with pytest.raises(InputError, match=reason) as refused:
        worlds.build(name, instances)
    assert "\n" not in str(refused.value)
