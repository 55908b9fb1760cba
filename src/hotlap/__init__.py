"""Tune the controller of a racing quadrotor so that it flies a track at the limit, and prove it.

In short:

    scenario = prepare("circle-34")
    guess = scenario.space.first_guess(len(scenario.segments))
    asked = Configuration(scenario, "built-in", Metric.TIME, "metropolis_hastings", TuningSettings(), guess)
    with Study.open("runs/mine", asked) as study:
        result = study.run(Objective(scenario, BuiltIn()))
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from hotlap.core.version import __version__ as __version__

if TYPE_CHECKING:
    from hotlap.core.errors import HotlapError, InputError, PlanningError
    from hotlap.core.parameters import ParameterSpace
    from hotlap.core.records import Flights, Scores
    from hotlap.files.descriptions import load_parameters, load_quadrotor, load_race, load_track, save_parameters
    from hotlap.flight.controller import Controller
    from hotlap.planning import plan
    from hotlap.planning.preparation import prepare
    from hotlap.planning.reference_csv import load_reference, save_reference
    from hotlap.reference.reference import Reference
    from hotlap.reference.scenario import Scenario
    from hotlap.reference.segmentation import Segments, segment
    from hotlap.study.configuration import Configuration
    from hotlap.study.study import Study
    from hotlap.tuning.goal import Goal, parse_goal
    from hotlap.tuning.loop import Tuning, TuningSettings, tune
    from hotlap.tuning.objective import Objective
    from hotlap.tuning.scoring import Metric
    from hotlap.worlds.built_in import BuiltIn

_HOMES = {
    "core.errors": ("HotlapError", "InputError", "PlanningError"),
    "core.parameters": ("ParameterSpace",),
    "core.records": ("Flights", "Scores"),
    "files.descriptions": ("load_parameters", "load_quadrotor", "load_race", "load_track", "save_parameters"),
    "flight.controller": ("Controller",),
    "planning": ("plan",),
    "planning.preparation": ("prepare",),
    "planning.reference_csv": ("load_reference", "save_reference"),
    "reference.reference": ("Reference",),
    "reference.scenario": ("Scenario",),
    "reference.segmentation": ("Segments", "segment"),
    "study.configuration": ("Configuration",),
    "study.study": ("Study",),
    "tuning.goal": ("Goal", "parse_goal"),
    "tuning.loop": ("Tuning", "TuningSettings", "tune"),
    "tuning.objective": ("Objective",),
    "tuning.scoring": ("Metric",),
    "worlds.built_in": ("BuiltIn",),
}
_HOME = {name: module for module, names in _HOMES.items() for name in names}

__all__ = [
    "BuiltIn",
    "Configuration",
    "Controller",
    "Flights",
    "Goal",
    "HotlapError",
    "InputError",
    "Metric",
    "Objective",
    "ParameterSpace",
    "PlanningError",
    "Reference",
    "Scenario",
    "Scores",
    "Segments",
    "Study",
    "Tuning",
    "TuningSettings",
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
