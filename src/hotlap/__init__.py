"""Tune the controller of a racing quadrotor so that it flies a track at the limit, and prove it.

In short:

    course = prepare("circle-34")
    guess = course.space.first_guess(len(course.segments))
    asked = Configuration(course, "built-in", Metric.TIME, "metropolis_hastings", TuningSettings(), guess)
    with Study.open("runs/mine", asked) as study:
        result = carry_out(study, Objective(course, BuiltIn()))
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hotlap.configuration import Configuration
    from hotlap.course import Course
    from hotlap.errors import HotlapError, InputError, PlanningError
    from hotlap.files import load_parameters, load_quadrotor, load_race, load_track, save_parameters
    from hotlap.flight.controller import Controller
    from hotlap.goal import Goal, parse_goal
    from hotlap.objective import Objective
    from hotlap.parameters import ParameterSpace
    from hotlap.planning import plan
    from hotlap.preparation import prepare
    from hotlap.records import Flights, Scores
    from hotlap.reference import Reference
    from hotlap.reference_csv import load_reference, save_reference
    from hotlap.scoring import Metric
    from hotlap.segmentation import Segments, segment
    from hotlap.study import Study, carry_out
    from hotlap.tuning import Tuning, TuningSettings, tune
    from hotlap.worlds.built_in import BuiltIn

__version__ = "0.1.0.dev0"

_HOMES = {
    "configuration": ("Configuration",),
    "course": ("Course",),
    "errors": ("HotlapError", "InputError", "PlanningError"),
    "files": ("load_parameters", "load_quadrotor", "load_race", "load_track", "save_parameters"),
    "flight.controller": ("Controller",),
    "goal": ("Goal", "parse_goal"),
    "objective": ("Objective",),
    "parameters": ("ParameterSpace",),
    "planning": ("plan",),
    "preparation": ("prepare",),
    "records": ("Flights", "Scores"),
    "reference": ("Reference",),
    "reference_csv": ("load_reference", "save_reference"),
    "scoring": ("Metric",),
    "segmentation": ("Segments", "segment"),
    "study": ("Study", "carry_out"),
    "tuning": ("Tuning", "TuningSettings", "tune"),
    "worlds.built_in": ("BuiltIn",),
}
_HOME = {name: module for module, names in _HOMES.items() for name in names}

__all__ = [
    "BuiltIn",
    "Configuration",
    "Controller",
    "Course",
    "Flights",
    "Goal",
    "HotlapError",
    "InputError",
    "Metric",
    "Objective",
    "ParameterSpace",
    "PlanningError",
    "Reference",
    "Scores",
    "Segments",
    "Study",
    "Tuning",
    "TuningSettings",
    "carry_out",
    "load_parameters",
    "load_quadrotor",
    "load_race",
    "load_reference",
    "load_track",
    "parse_goal",
    "plan",
    "prepare",
    "save_parameters",
    "save_reference",
    "segment",
    "tune",
]


def __getattr__(name: str) -> Any:
    """Import a public name where it is first used (PEP 562), so that importing hotlap loads nothing."""
    if name not in _HOME:
        raise AttributeError(f"module 'hotlap' has no attribute '{name}'")
    value = getattr(import_module(f"hotlap.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
