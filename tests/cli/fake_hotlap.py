"""The program with a world, a planner and pictures that take no time; also run as a process: fake_hotlap.py ARGUMENTS."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))

from fake_world import FakeWorld, make_scenario
from first_guess.small import DEFAULT, make_race, make_set
from hotlap import worlds
from hotlap.api import scenarios
from hotlap.core.errors import UnknownNameError
from hotlap.core.records import Log
from hotlap.first_guess import guess
from hotlap.planning import preparation
from hotlap.reference.segmentation import SegmentationRule, segment


@dataclass
class Loud(FakeWorld):
    """Says on standard error when it flies, and keeps a log of nothing."""

    loud: bool = False

    def needs_compiling(self, scenario) -> bool:  # noqa: ARG002
        return True

    def prepare(self, _):
        pass

    def fly(self, scenario, parameters, seeds, *, vehicle_parameters=None, log=()):
        if self.loud:
            sys.stderr.write("flying\n")
            sys.stderr.flush()
        flights = super().fly(scenario, parameters, seeds, vehicle_parameters=vehicle_parameters)
        steps = np.zeros(3)
        return replace(flights, logs={i: Log(steps, np.zeros((3, 13)), np.zeros((3, 4)), np.full((3, 4), np.nan)) for i in log})


def build(name: str, _instances: int = 1, _engine: object = None) -> Loud:
    if name not in {"built-in", "fake"}:  # as a study knows it
        raise UnknownNameError("world", name, ["built-in"], key="on")
    pause = float(os.environ.get("FAKE_PAUSE", "0"))
    return Loud(name="fake", pause=pause, loud=pause > 0)


def module(name: str, **contents) -> ModuleType:
    made = ModuleType(name)
    vars(made).update(contents)
    return made


def draw_comparison(folder, _):
    (folder / "curves.svg").write_text("<svg/>", encoding="utf-8")
    return (folder / "curves.svg",)


MODULES = {
    "hotlap.report.comparison": module("comparison", draw_comparison=draw_comparison),
}
LEARNT = make_set(make_race("straight", "8"), candidates=(DEFAULT,))
REPLACEMENTS: list[tuple[Any, str, Any]] = [
    (worlds, "build", build),
    (preparation, "plan", lambda *_, **__: make_scenario().reference),
    (scenarios, "shipped", lambda: LEARNT),
    (guess, "shipped", lambda: LEARNT),
    (
        preparation,
        "segment",
        lambda reference, rule: make_scenario().segments if rule is SegmentationRule.PAPER else segment(reference, rule),
    ),
]
"""What to put in place of what flies, plans and draws."""


if __name__ == "__main__":
    from hotlap.cli import main

    for place, name, value in REPLACEMENTS:
        setattr(place, name, value)
    sys.modules.update(MODULES)
    sys.exit(main())
