"""Simulators that workers open: flights are those of simulators that are opened here, bit for bit."""

from __future__ import annotations

import numpy as np
import pytest

from flight.scenarios import make_scenario, parameters
from hotlap import worlds
from hotlap.core.errors import HotlapError, InputError
from hotlap.system.process_pool import Processes
from hotlap.worlds.on_workers import OnWorkers, merge
from worlds.test_stepped import assert_same

OWN = "worlds.own_simulator.Own"
SCENARIO = make_scenario(noise={"position": 0.05, "rates": 0.1})


@pytest.mark.parametrize(("name", "processes"), [(OWN, 1), (f"{OWN}:2", 2)])
def test_a_batch_is_flown_as_here_whoever_flies(name, processes):
    here, there, ended = worlds.build(name, 2), worlds.build(name, 2, Processes(processes)), []
    assert isinstance(there, OnWorkers)
    there.watch = ended.append
    batch = SCENARIO, parameters(5), np.arange(5)
    one, other = here.fly(*batch, log=[1, 4]), there.fly(*batch, log=[1, 4])
    assert_same(one, other)
    assert list(other.logs) == [1, 4]
    assert ended == [1, 2, 3, 4, 5]
    assert here.capacity(SCENARIO) == there.capacity(SCENARIO)


def test_parts_of_a_batch_make_the_batch():
    world = worlds.build(OWN)
    whole = world.fly(SCENARIO, parameters(4), np.arange(4), log=[0, 3])
    parts = [world.fly(SCENARIO, parameters(4)[k : k + 2], np.arange(k, k + 2), log=[k // 2]) for k in (0, 2)]
    assert_same(whole, merge(parts))


def test_what_workers_cannot_open_is_told_as_here():
    with pytest.raises(InputError, match="there is no such drone"):
        worlds.build("worlds.own_simulator.cannot_open", engine=Processes(1)).fly(SCENARIO, parameters(1), np.arange(1))
    with pytest.raises(InputError, match="cluster: has no airsim"):
        worlds.build("airsim:127.0.0.1:1", engine=Processes(1))
    with pytest.raises(HotlapError, match="flies the vehicle that it has"):
        worlds.build(OWN, engine=Processes(1)).fly(SCENARIO, parameters(1), np.arange(1), vehicle_parameters=np.ones((1, 3)))


@pytest.mark.parametrize(
    ("name", "reads"), [("betaflight", ()), ("betaflight:diff.txt", ("diff.txt",)), (OWN, ("worlds.own_simulator",)), ("built-in", ())]
)
def test_what_a_world_reads_must_be_the_same_everywhere(name, reads):
    assert tuple(filter(None, worlds.needed(name))) == reads
