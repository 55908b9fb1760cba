"""Short flights in AirSim's stand-in."""

from __future__ import annotations

from contextlib import closing

import numpy as np

from hotlap.worlds.airsim import open_simulator
from hotlap.worlds.airsim.simulator import STEP, AirSim
from hotlap.worlds.simulator import Start
from worlds.airsim_plant import AIRSIM as VEHICLE
from worlds.airsim_plant import Plant
from worlds.airsim_server import Server

HOVER = np.array([[9.80665, 0.0, 0.0, 0.0]])
START = Start(np.array([1.0, 2.0, 3.0, 0.5, 0.5, 0.5, 0.5, 0.3, 0.2, 0.1, 0.3, 0.2, 0.1]))
LEVEL = Start(np.array([0.0, 0.0, 5.0, 1.0, *(0.0,) * 9]))
PATIENCE = 1.0  # s, of tests in which nobody answers


def served(**options) -> Server:
    return Server(Plant(VEHICLE, delayed=False), **options)


def connect(server: Server, vehicle: str = "", timeout: float = 5.0) -> closing[AirSim]:
    return closing(open_simulator(None, 0, f"127.0.0.1:{server.port}:{vehicle}", timeout))


def fly(simulator: AirSim, start: Start = LEVEL, periods: int = 40) -> None:
    simulator.reset(0, start)
    for k in range(periods):
        simulator.advance(HOVER, (3 + (k % 3 == 0)) * STEP)
