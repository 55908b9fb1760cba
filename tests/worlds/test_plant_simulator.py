"""The built-in plant, and a program of its own, keep to what every simulator keeps to."""

from __future__ import annotations

from hotlap.race.quadrotor import Quadrotor
from hotlap.worlds.plant_simulator import PlantSimulator
from worlds.contract import SimulatorContract
from worlds.process_simulator import ProcessSimulator


class TestPlant(SimulatorContract):
    def make(self, quadrotor: Quadrotor) -> PlantSimulator:
        return PlantSimulator(quadrotor)


class TestPlantInLanes(SimulatorContract):
    def make(self, quadrotor: Quadrotor) -> PlantSimulator:
        return PlantSimulator(quadrotor, lanes=3)


class TestProcess(SimulatorContract):
    """Its drone does at once what it is told."""

    def make(self, _quadrotor: Quadrotor) -> ProcessSimulator:
        return ProcessSimulator()

    def lose(self, simulator: ProcessSimulator) -> None:
        simulator.process.kill()
