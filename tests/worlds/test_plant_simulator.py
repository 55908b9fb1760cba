"""The built-in plant, and a program of its own, keep to what every simulator keeps to."""

from __future__ import annotations

import runpy
from dataclasses import replace
from pathlib import Path

from flight.scenarios import make_scenario
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


EXAMPLE = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "own_simulator.py"))


class TestExample(SimulatorContract):
    """That of the documentation."""

    def make(self, quadrotor: Quadrotor):
        scenario = make_scenario()
        return EXAMPLE["MySimulator"](replace(scenario, race=scenario.race.model_copy(update={"vehicle": quadrotor})), 0)


class TestProcess(SimulatorContract):
    """Its drone does at once what it is told."""

    def make(self, _quadrotor: Quadrotor) -> ProcessSimulator:
        return ProcessSimulator()

    def lose(self, simulator: ProcessSimulator) -> None:
        simulator.process.kill()
