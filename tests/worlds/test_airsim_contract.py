"""AirSim over the wire keeps to what every simulator keeps to."""

from __future__ import annotations

from contextlib import ExitStack

import pytest

from flight.scenarios import make_scenario
from hotlap.race.quadrotor import Quadrotor
from hotlap.worlds.airsim import open_simulator
from hotlap.worlds.airsim.simulator import AirSim
from worlds.airsim_flights import VEHICLE, served
from worlds.airsim_server import Server
from worlds.contract import SimulatorContract

NOISE = {"thrust": 0.01, "rates": 0.02, "thrust_bias": 0.01, "position": 0.03, "velocity": 0.03, "attitude": 0.01}


class TestAirSim(SimulatorContract):
    """It flies its own vehicle alone, whose throttle stays above 0.06 and whose body has drag."""

    quadrotor = VEHICLE
    scenario = make_scenario(VEHICLE.model_dump(exclude={"name"}), model=VEHICLE.model_dump(), noise=NOISE)
    fall = 0.2
    servers: ExitStack
    latest: Server

    @pytest.fixture(scope="class", autouse=True)
    @classmethod
    def _served(cls):
        """Servers of all tests."""
        with ExitStack() as cls.servers:
            yield

    def make(self, _quadrotor: Quadrotor) -> AirSim:
        type(self).latest = self.servers.enter_context(served())
        return open_simulator(self.scenario, 0, f"127.0.0.1:{self.latest.port}")

    def lose(self, _simulator: AirSim) -> None:
        self.latest.kill()
