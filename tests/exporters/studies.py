"""Studies that have something to export: the small scenario of the flight core, flown by formula."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from fake_world import FakeWorld
from flight.scenarios import make_scenario
from hotlap.exporters.tuned import ExportedParameters
from hotlap.files.descriptions import save_parameters
from hotlap.files.parameters_file import SavedParameters
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentClass, Segments
from hotlap.study.configuration import Configuration
from hotlap.study.study import Study
from hotlap.tuning.loop import TuningSettings
from hotlap.tuning.objective import Objective
from hotlap.tuning.scoring import Metric

VALUES = np.array([[33.5, 357.0, 44.0, 7.1, 6.0], [150.0, 1200.25, 3.3, 1 + 1e-15, 4.7]])
"""Parameters of two segments that differ in everything; one of them is not short in decimals."""


def tune(folder: Path, scenario: Scenario | None = None, *, fly: bool = True, save: bool = True, **settings: Any) -> Study:
    """A finished study, open to read; its parameters are `VALUES`, whatever it has found. Or one that has not flown, or not ended."""
    scenario, world = scenario or make_scenario(), FakeWorld()
    asked = TuningSettings(**{"budget": 30, "validation": 20, "seed": 3, **settings})
    guess = scenario.space.first_guess(len(scenario.segments))
    configuration = Configuration(scenario, world.name, Metric.TIME, "metropolis_hastings:tied", asked, guess)
    with Study.open(folder, configuration) as study:
        if fly:
            study.run(Objective(scenario, world))
    if save:
        save_parameters(folder / "parameters.toml", saved(scenario))
    return Study.read(folder)


def saved(scenario: Scenario) -> SavedParameters:
    """`VALUES` for a scenario of two segments, with provenance."""
    return SavedParameters(scenario.race.name, scenario.space.names, scenario.segments, VALUES, {"seed": 3, "validated_rate": 0.985})


def tuned(scenario: Scenario) -> ExportedParameters:
    """`VALUES`, as they are read from a study."""
    return ExportedParameters(scenario, saved(scenario), VALUES)


def alternating() -> Segments:
    """Two segments of which one has two pieces."""
    kinds = (SegmentClass.ASCENT, SegmentClass.FLAT, SegmentClass.ASCENT)
    return Segments(np.array([0.0, 1.0, 2.25]), kinds, 3.4, (0, 1, 0))
