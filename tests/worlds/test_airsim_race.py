"""Whole races over AirSim's wire: close to the same races in process, in an order of calls that the real server would survive."""

from __future__ import annotations

import numpy as np
import pytest

from flight.scenarios import TUNED, make_scenario, parameters
from hotlap.core.errors import InputError
from hotlap.core.records import Cause, End
from hotlap.planning.preparation import prepare
from hotlap.reference.scenario import Scenario
from hotlap.worlds.airsim import open_simulator
from hotlap.worlds.built_in import BuiltIn
from hotlap.worlds.instance import Instance
from hotlap.worlds.stepped import Stepped
from worlds.airsim_plant import AIRSIM as VEHICLE
from worlds.airsim_plant import Plant
from worlds.airsim_server import Server

pytestmark = pytest.mark.check  # whole races over a wire

NOISE = {"thrust": 0.01, "rates": 0.02, "position": 0.03, "velocity": 0.03, "attitude": 0.01}


def scenario_of(**changes) -> Scenario:
    """The small race, flown and planned for by AirSim's quadrotor."""
    return make_scenario(VEHICLE.model_dump(exclude={"name", "provenance"}), model=VEHICLE.model_dump(), noise=NOISE, **changes)


def served(**options) -> Server:
    return Server(Plant(VEHICLE, delayed=True), **options)


def world(server: Server, timeout: float = 5.0) -> Stepped:
    return Stepped("airsim", lambda scenario, number: open_simulator(scenario, number, f"127.0.0.1:{server.port}", timeout))


def assert_close(scenario: Scenario, asked: np.ndarray, **options) -> None:
    """The same flights over the wire and in process: the clocks differ by a step, so that the paths differ by centimetres."""
    seeds = np.arange(len(asked))
    home = BuiltIn("float64").fly(scenario, asked, seeds, log=[0])
    with served(**options) as server:
        away = world(server)
        flown = away.fly(scenario, asked, seeds, log=[0])
        away.close()
        assert server.violations == []
        assert server.holds == 0
    np.testing.assert_array_equal(flown.end, home.end)
    np.testing.assert_array_equal(flown.gates_passed, home.gates_passed)
    np.testing.assert_allclose(flown.mean_error, home.mean_error, atol=0.02)
    np.testing.assert_allclose(flown.closest_distance, home.closest_distance, atol=0.06)
    np.testing.assert_allclose(flown.lap_time, home.lap_time, atol=0.02)
    rows = min(len(flown.logs[0].times), len(home.logs[0].times))
    np.testing.assert_allclose(flown.logs[0].states[:rows, :3], home.logs[0].states[:rows, :3], atol=0.15)
    np.testing.assert_allclose(flown.logs[0].rotor_thrusts[:rows].mean(), home.logs[0].rotor_thrusts[:rows].mean(), rtol=0.02)


def test_a_race_over_the_wire_is_the_race_in_process():
    assert_close(scenario_of(), parameters(2), loses_cancel=(50, 90))


@pytest.mark.check
def test_a_built_in_race_over_the_wire_is_the_race_in_process():
    scenario = prepare("real-airsim-circle")
    assert_close(scenario, np.tile(TUNED, (1, len(scenario.segments), 1)))


def test_a_flight_depends_on_its_seed_alone():
    scenario = scenario_of()
    with served() as server:
        away = world(server)
        flown = away.fly(scenario, parameters(3), np.array([4, 5, 4]))
        assert flown.mean_error[0] == flown.mean_error[2] != flown.mean_error[1]
        away.close()


def test_a_connection_that_is_cut_loses_one_flight():
    with served(cut_at=100) as server:
        away, lines = world(server), []
        away.note = lines.append
        flown = away.fly(scenario_of(), parameters(2), np.arange(2))
        away.close()
    assert (flown.end[0], flown.cause[0]) == (End.CRASHED, Cause.LOST)
    assert flown.end[1] != End.CRASHED
    assert len(lines) == 1
    assert lines[0].startswith("airsim: AirSim at 127.0.0.1:")


def test_a_simulator_that_was_ended_stops_the_study():
    with served() as server:
        away = world(server)
        away.note = lambda line: server.kill()
        server.cut_at = 100
        with pytest.raises(InputError, match=r"^on: AirSim at .* nobody listens there"):
            away.fly(scenario_of(), parameters(2), np.arange(2))


def test_a_silent_simulator_does_not_hold_up_a_study_for_ever():
    with served() as server:
        away = world(server, timeout=0.3)
        away.note = lambda _: None
        server.silent_at = "simContinueForTime"
        with pytest.raises(InputError, match="simContinueForTime was not answered within"):
            away.fly(scenario_of(), parameters(1), np.arange(1))


@pytest.mark.parametrize(("delay", "added"), [(0.0, 0.0), (0.0075, 0.0), (0.0125, 0.005), (0.045, 0.0375)])
def test_the_dead_time_that_airsim_has_of_its_own_is_not_counted_twice(delay, added):
    scenario = make_scenario({"delay": delay})
    with served() as server:
        instance = Instance("airsim", lambda *_: open_simulator(scenario, 0, f"127.0.0.1:{server.port}"), 0)
        assert instance.simulator(scenario)[1].delay == pytest.approx(added)
        instance.close()
