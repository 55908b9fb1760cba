"""A small study in a world that takes no time."""

from __future__ import annotations

from pathlib import Path

from fake_world import make_scenario
from hotlap.reference.scenario import Scenario
from hotlap.study.configuration import Configuration
from hotlap.study.snapshot import Snapshot, read_snapshot
from hotlap.study.study import Study
from hotlap.tuning.goal import parse_goal
from hotlap.tuning.loop import TuningSettings
from hotlap.tuning.objective import Objective
from plausible_world import PlausibleWorld


class AnyVehicle(PlausibleWorld):
    """Takes another vehicle, and flies as ever."""

    takes_vehicle_parameters = True

    def fly(self, scenario, parameters, seeds, *, vehicle_parameters=None, log=()):  # noqa: ARG002
        return super().fly(scenario, parameters, seeds, log=log)


def configure(scenario: Scenario | None = None, goal: str = "completion=1", **settings) -> Configuration:
    scenario = scenario or make_scenario()
    asked = TuningSettings(**{"seed": 3, "budget": 20, "validation": 20, "goal": parse_goal(goal), **settings})
    return Configuration(
        scenario, "plausible", asked.goal.metric, "metropolis_hastings:tied", asked, scenario.space.first_guess(len(scenario.segments))
    )


def carry(folder: Path, configuration: Configuration, world=None, command: str = "") -> Snapshot:
    """Run a study to its end, and read it."""
    with Study.open(folder, configuration, command) as study:
        study.run(Objective(configuration.scenario, world or PlausibleWorld(), configuration.metric))
        return read_snapshot(study)


def begin(folder: Path, configuration: Configuration) -> Snapshot:
    """A study without flights."""
    with Study.open(folder, configuration) as study:
        return read_snapshot(study)
