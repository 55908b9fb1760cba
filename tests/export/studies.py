"""Studies that have something to export: the small course of the flight core, flown by formula."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from fake_world import FakeWorld
from flight.courses import make_course
from hotlap.configuration import Configuration
from hotlap.course import Course
from hotlap.export.tuned import Tuned
from hotlap.files import save_parameters
from hotlap.objective import Objective
from hotlap.saved_parameters import SavedParameters
from hotlap.scoring import Metric
from hotlap.segmentation import SegmentClass, Segments
from hotlap.study import Study, carry_out
from hotlap.tuning import TuningSettings

VALUES = np.array([[33.5, 357.0, 44.0, 7.1, 6.0], [150.0, 1200.25, 3.3, 1 + 1e-15, 4.7]])
"""Parameters of two segments that differ in everything; one of them is not short in decimals."""


def tune(folder: Path, course: Course | None = None, *, fly: bool = True, save: bool = True, **settings: Any) -> Study:
    """A finished study, open to read; its parameters are `VALUES`, whatever it has found. Or one that has not flown, or not ended."""
    course, world = course or make_course(), FakeWorld()
    asked = TuningSettings(**{"budget": 30, "validation": 20, "seed": 3, **settings})
    guess = course.space.first_guess(len(course.segments))
    configuration = Configuration(course, world.name, Metric.TIME, "metropolis_hastings:tied", asked, guess)
    with Study.open(folder, configuration) as study:
        if fly:
            carry_out(study, Objective(course, world))
    if save:
        save_parameters(folder / "parameters.toml", saved(course))
    return Study.read(folder)


def saved(course: Course) -> SavedParameters:
    """`VALUES` for a course of two segments, with provenance."""
    return SavedParameters(course.race.name, course.space.names, course.segments, VALUES, {"seed": 3, "validated_rate": 0.985})


def tuned(course: Course) -> Tuned:
    """`VALUES`, as they are read from a study."""
    return Tuned(course, saved(course), VALUES)


def alternating() -> Segments:
    """Two segments of which one has two pieces."""
    kinds = (SegmentClass.ASCENT, SegmentClass.FLAT, SegmentClass.ASCENT)
    return Segments(np.array([0.0, 1.0, 2.25]), kinds, 3.4, (0, 1, 0))
