"""The controller alone holds an independent plant that loses thrust, sags and is blown about."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hotlap.core.errors import HotlapError
from hotlap.flight.controller import Controller
from hotlap.race.controllers import ControllerKind
from hotlap.reference.scenario import Scenario

from .own_plant import Drone
from .scenarios import TUNED, make_scenario

LOST_FROM, PERIOD = 4.0, 0.01
GAINS = {"mpc": TUNED, "mpc_drag": TUNED, "geometric": (8.0, 12.0, 4.0, 5.0, 10.0, 3.0)}
KINDS = ("mpc", *(pytest.param(kind, marks=pytest.mark.check) for kind in ("mpc_drag", "geometric")))


def scenario_of(kind: str = "mpc", *, on: bool = True) -> Scenario:
    """The small race, flown by a kind of controller, offset-free or not; it predicts over a lag of the plant."""
    scenario = make_scenario()
    race = scenario.race.with_controller(ControllerKind(kind))
    settings = race.controller.model_copy(update={"offset_free": on, "lag_lead": 0.5, "thrust": (0.1, 25.0)})
    return replace(scenario, race=race.model_copy(update={"controller": settings}))


def fly(scenario: Scenario, gains: tuple[float, ...], until: float = 7.5, **day: Any) -> tuple[np.ndarray, np.ndarray, Controller]:
    """Times, errors of position, shape (steps, 3), and the controller after the flight."""
    start = scenario.reference.table[0]
    drone, controller = (
        Drone(start[:3], start[7:10], Rotation.from_quat(np.roll(start[3:7], -1)), **day),
        Controller(scenario, np.array(gains)),
    )
    times, errors = np.arange(0.0, until, PERIOD), []
    for time in times:
        errors.append(drone.position - scenario.reference.position_at(np.array([time]))[0])
        drone.fly(controller.command(time, drone.state), PERIOD)
    return times, np.array(errors), controller


@pytest.mark.parametrize("kind", KINDS)
def test_height_is_held_after_a_loss_of_thrust_with_a_sagging_battery_and_gusts(kind):
    day = {"lost": 0.15, "lost_from": LOST_FROM, "sag": 0.015, "gusts": 1.0}
    times, errors, controller = fly(scenario_of(kind), GAINS[kind], **day)
    late = times >= LOST_FROM + 1.0
    assert np.abs(errors[late, 2]).max() < 0.1
    assert controller.thrust_effectiveness == pytest.approx(0.85 * (1 - 0.015 * 7.5), abs=0.06)


def test_without_the_observer_it_is_not():
    times, errors, _ = fly(scenario_of(on=False), TUNED, lost=0.15, lost_from=LOST_FROM)
    assert np.abs(errors[times >= LOST_FROM + 1.0, 2]).max() > 0.1


def test_a_steady_wind_is_found():
    wind = np.array([2.0, -1.0, 0.0])
    *_, controller = fly(scenario_of(), TUNED, 3.0, wind=wind, gust_time=1e9)
    np.testing.assert_allclose(controller.disturbance, wind, atol=0.4)


def test_an_effectiveness_that_is_known_from_hovering_is_used_from_the_start():
    scenario = scenario_of()
    errors = {}
    for known in (1.0, 0.8):
        start = scenario.reference.table[0]
        drone = Drone(start[:3], start[7:10], Rotation.identity(), lost=0.2, thrust=9.81 / 0.8)
        controller = Controller(scenario, np.array(TUNED))
        controller.reset(thrust_effectiveness=known)
        assert controller.thrust_effectiveness == known
        heights = []
        for time in np.arange(0.0, 1.0, PERIOD):
            drone.fly(controller.command(time, drone.state), PERIOD)
            heights.append(drone.position[2] - scenario.reference.position_at(np.array([time + PERIOD]))[0, 2])
        errors[known] = np.abs(heights).max()
    assert errors[0.8] < 0.5 * errors[1.0]


def test_a_pause_teaches_nothing():
    scenario = scenario_of()
    controller, states = Controller(scenario, np.array(TUNED)), scenario.reference.table[:, :10]
    for row in range(100):
        controller.command(0.01 * row, states[row])
    before = controller.thrust_effectiveness, *controller.disturbance
    controller.command(2.0, states[200])
    assert (controller.thrust_effectiveness, *controller.disturbance) == before


@pytest.mark.parametrize("start", [{"thrust_effectiveness": 0.5}, {"disturbance": (0.0, 20.0, 0.0)}, {"disturbance": (0.0, 0.0)}])
def test_a_start_out_of_range_is_refused(start):
    with pytest.raises(HotlapError, match="estimates begin with"):
        Controller(scenario_of(), np.array(TUNED)).reset(**start)


def test_a_controller_that_estimates_nothing_takes_no_start():
    controller = Controller(scenario_of(on=False), np.array(TUNED))
    assert not controller.is_offset_free
    with pytest.raises(HotlapError, match="estimates nothing"):
        controller.reset(thrust_effectiveness=0.9)
