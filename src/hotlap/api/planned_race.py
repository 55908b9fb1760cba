"""A planned race: a race written with the settings of the planner that a search has found, and the parameters that fly it."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hotlap.analysis.plan_trials import PlanSettings
from hotlap.core.shown import Shown
from hotlap.core.version import __version__
from hotlap.files.descriptions import PARAMETERS_FILE, save, save_parameters
from hotlap.files.parameters_file import Remark, SavedParameters
from hotlap.planning.preparation import prepare
from hotlap.race.race import Race
from hotlap.reference.scenario import Scenario
from hotlap.tuning.goal_forms import LAP_TIME

RACE_FILE = "race.toml"


@dataclass(frozen=True, repr=False)
class PlannedRace(Shown):
    """Where a planned race lies.

    Attributes:
        scenario: of it.
        race: its file.
        parameters: the file of its parameters.
    """

    scenario: Scenario
    race: Path
    parameters: Path

    @property
    def again(self) -> str:
        """The command that flies it."""
        return shlex.join(["hotlap", "fly", str(self.race), "--parameters", str(self.parameters.parent)])

    @property
    def study(self) -> str:
        """The command that makes a study of it."""
        return shlex.join(["hotlap", "tune", str(self.race), "--first-guess", str(self.parameters.parent)])


def write_planned_race(
    folder: Path, race: Race, name: str, plan_settings: PlanSettings, values: Sequence[Sequence[float]], known: Mapping[str, Remark]
) -> PlannedRace:
    """Write a race, with its plan's settings, and its parameters.

    Args:
        folder: made if there is none.
        race: as it was given.
        name: of the race that is written.
        plan_settings: of its plan.
        values: K parameters of each segment.
        known: remarks to go with the parameters.

    Raises:
        InputError: a file cannot be written.
        PlanningError: there is no such plan.
    """
    planned = plan_settings.applied(race).model_copy(update={"name": name})
    folder.mkdir(parents=True, exist_ok=True)
    save(folder / RACE_FILE, planned)
    scenario = prepare(planned)
    remarks = {"hotlap": __version__, "goal": LAP_TIME, **known}
    parameters = SavedParameters(name, scenario.space.names, scenario.segments, np.array(values), remarks)
    save_parameters(folder / PARAMETERS_FILE, parameters)
    return PlannedRace(scenario, folder / RACE_FILE, folder / PARAMETERS_FILE)
