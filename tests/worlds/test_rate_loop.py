"""The rate loop alone asks the rotors for what that of the built-in plant asks for."""

from __future__ import annotations

import numpy as np
import pytest

from hotlap.race.quadrotor import Quadrotor, RotorLayout
from hotlap.race.race import PLANT_STEP
from hotlap.worlds.plant_simulator import PlantSimulator
from hotlap.worlds.rate_loop import RateLoop
from hotlap.worlds.simulator import Start
from worlds.contract import PLAIN

AT_ONCE = {"motor_time": (0.0, 0.0), "rotor_thrust": (0.2, 5.0)}
VEHICLES = [
    PLAIN.model_copy(update=AT_ONCE),
    PLAIN.model_copy(update={**AT_ONCE, "torque_damping": 0.6, "layout": RotorLayout.PLUS, "rate_gain": (30.0, 25.0, 6.0)}),
]


def known(quadrotor: Quadrotor) -> Quadrotor:
    """A heavier one of other proportions."""
    return quadrotor.model_copy(update={"mass": 0.9, "arm": 0.2, "inertia": (0.004, 0.0035, 0.006)})


@pytest.mark.parametrize("quadrotor", VEHICLES, ids=["x", "plus, damped"])
@pytest.mark.parametrize("believed", [None, known], ids=["as it is", "as another"])
def test_rotors_that_follow_at_once_give_what_the_loop_asks_for(quadrotor, believed):
    known_as = None if believed is None else believed(quadrotor)
    loop, simulator = RateLoop(quadrotor, known_as), PlantSimulator(quadrotor, known_as)
    chance, saturated = np.random.default_rng(0), 0
    state = np.array([0.0, 0.0, 9.0, 1.0, *np.zeros(9)])
    for _ in range(200):
        state[10:] = chance.uniform(-3, 3, 3)
        simulator.reset(0, Start(state))
        command = np.array([[chance.uniform(2, 25), *chance.uniform(-6, 6, 3)]])
        asked = loop(simulator.states(), simulator.rotor_thrusts(), command)
        simulator.advance(command, PLANT_STEP)
        np.testing.assert_allclose(simulator.rotor_thrusts(), asked, rtol=1e-9)
        saturated += int(((asked <= 0.2) | (asked >= 5.0)).any())
    assert 20 < saturated < 180


def test_hovering_shares_the_weight_among_all_lanes_and_rotors():
    states = np.tile([0.0, 0.0, 9.0, 1.0, *np.zeros(9)], (3, 1))
    weight = PLAIN.mass * PLAIN.gravity
    asked = RateLoop(PLAIN)(states, np.full((3, 4), weight / 4), np.tile([PLAIN.gravity, 0, 0, 0], (3, 1)))
    np.testing.assert_allclose(asked, weight / 4)
