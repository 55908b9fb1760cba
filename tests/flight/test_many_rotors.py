"""Whole flights of vehicles with six rotors, a mixer and a rate loop of their own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hotlap.dynamics.mixers import Mixer
from hotlap.race.rate_loop import LIMITS, Output, RateLoop

from .scenarios import fly, make_scenario

pytestmark = pytest.mark.check  # each number of rotors is compiled

ANGLES = 2 * np.pi * (np.arange(6) + 0.5) / 6
SIX: dict[str, Any] = {
    "rotors": tuple((0.17 * np.cos(a), 0.17 * np.sin(a), (-1.0) ** k) for k, a in enumerate(ANGLES)),
    "rotor_thrust": (0.0, 4.0),
    "mixer": Mixer.BETAFLIGHT,
    "rate_loop": RateLoop(p=(0.06, 0.06, 0.2), limit=LIMITS, output=Output.SPEED, idle=0.055),
    "rate_delay": 0.004,
}


def test_six_rotors_fly_the_small_race_and_are_logged_one_by_one():
    scenario = make_scenario(SIX, model=SIX)
    flights = fly(scenario, 20, log=[0, 19])
    assert (flights.gates_passed == len(flights.gate_times)).all()
    log = flights.logs[19]
    assert log.rotor_thrusts.shape == (len(log.times), 6)
    assert_allclose(log.rotor_thrusts[0], scenario.race.vehicle.mass * scenario.race.vehicle.gravity / 6, rtol=1e-6)
    assert log.rotor_thrusts.max() <= 4.0 * (1 + 1e-5)


def test_a_refilled_lane_remembers_nothing_of_the_flight_before():
    """Each flight alone is what it is among others, though its lane has flown others before."""
    scenario = make_scenario(SIX, model=SIX, noise={"rates": 0.3, "thrust": 0.05})
    together = fly(scenario, 40, seeds=np.arange(40))
    alone = fly(scenario, 1, seeds=[39])
    assert_array_equal(together.clock_distance[39], alone.clock_distance[0])
