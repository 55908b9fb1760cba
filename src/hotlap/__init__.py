"""Tune the controller of a racing quadrotor so that it flies a track at the limit, and prove it.

One call does what `hotlap tune` does: it plans the fastest flight through the gates, tunes in simulated flights, confirms and validates
the result, and writes a page about it:

    import hotlap

    tuned = hotlap.tune("circle-34", out="runs/mine")
    tuned.confirmed, tuned.validation, tuned.values, tuned.report

`hotlap.check`, `identify`, `plan`, `fly`, `lap`, `score`, `transfer`, `compare` and `export` do likewise. The pieces of which they are
made are reached by package:

    from hotlap import tuners
    from hotlap.planning.preparation import prepare
    from hotlap.tuning.loop import Tuning, TuningSettings, tune
    from hotlap.tuning.objective import Objective
    from hotlap.worlds import BuiltIn

    scenario = prepare("circle-34")
    run = Tuning(tuners.build("gate_gp"), scenario, TuningSettings(budget=200))
    for batch in tune(Objective(scenario, BuiltIn()), run):
        print(batch.flights, batch.best.completion)
"""

from __future__ import annotations

import warnings
from importlib import import_module
from typing import TYPE_CHECKING, Any

from hotlap.core.platforms import unsupported
from hotlap.core.version import __version__ as __version__

if TYPE_CHECKING:
    from hotlap.api.checking import check
    from hotlap.api.comparing import compare
    from hotlap.api.exporting import export
    from hotlap.api.flying import fly
    from hotlap.api.identifying import identify
    from hotlap.api.lapping import lap
    from hotlap.api.planning import plan
    from hotlap.api.scoring import score
    from hotlap.api.transferring import transfer
    from hotlap.api.tuning import tune
    from hotlap.core.errors import HotlapError, InputError, PlanningError
    from hotlap.files.descriptions import load_parameters, load_race
    from hotlap.flight.controller import Controller
    from hotlap.race.race import Race
    from hotlap.study.study import Study

__all__ = [
    "Controller",
    "HotlapError",
    "InputError",
    "PlanningError",
    "Race",
    "Study",
    "check",
    "compare",
    "export",
    "fly",
    "identify",
    "lap",
    "load_parameters",
    "load_race",
    "plan",
    "score",
    "transfer",
    "tune",
]

_HOMES = {
    "api.checking": ("check",),
    "api.comparing": ("compare",),
    "api.exporting": ("export",),
    "api.flying": ("fly",),
    "api.identifying": ("identify",),
    "api.lapping": ("lap",),
    "api.planning": ("plan",),
    "api.scoring": ("score",),
    "api.transferring": ("transfer",),
    "api.tuning": ("tune",),
    "core.errors": ("HotlapError", "InputError", "PlanningError"),
    "files.descriptions": ("load_parameters", "load_race"),
    "flight.controller": ("Controller",),
    "race.race": ("Race",),
    "study.study": ("Study",),
}
_FORMER_HOMES = {  # names of before, which go on working
    "core.parameters": ("ParameterSpace",),
    "core.records": ("Flights", "Scores"),
    "files.descriptions": ("load_quadrotor", "load_track", "save_parameters"),
    "planning.preparation": ("prepare",),
    "reference_files.csv": ("load_reference", "save_reference"),
    "reference.reference": ("Reference",),
    "reference.scenario": ("Scenario",),
    "reference.segmentation": ("Segments", "segment"),
    "study.configuration": ("Configuration",),
    "tuning.goal": ("Goal", "parse_goal"),
    "tuning.loop": ("Tuning", "TuningSettings"),
    "tuning.objective": ("Objective",),
    "tuning.scoring": ("Metric",),
    "worlds.built_in": ("BuiltIn",),
}
_RENAMED = {"Course": ("reference.scenario", "Scenario")}
_GONE = {"carry_out": "hotlap.study.study.Study.run, a method"}
_HOME = {name: module for module, names in _HOMES.items() for name in names}
_FORMER_HOME = {name: module for module, names in _FORMER_HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Import a public name where it is first used (PEP 562), so that importing hotlap loads nothing."""
    if name in _HOME:
        if unsupported():
            raise ImportError(unsupported())
        value = getattr(import_module(f"hotlap.{_HOME[name]}"), name)
        globals()[name] = value
        return value
    if name in _FORMER_HOME:
        home = f"hotlap.{_FORMER_HOME[name]}"
        warnings.warn(f"hotlap.{name} is {home}.{name} now", DeprecationWarning, stacklevel=2)
        return getattr(import_module(home), name)
    if name in _RENAMED:
        module, present = _RENAMED[name]
        warnings.warn(f"hotlap.{name} is hotlap.{module}.{present} now", DeprecationWarning, stacklevel=2)
        return getattr(import_module(f"hotlap.{module}"), present)
    instead = f"; it is {_GONE[name]}, now" if name in _GONE else ""
    raise AttributeError(f"module 'hotlap' has no attribute '{name}'{instead}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
