"""Flying: scenarios, worlds and parameters made ready for commands that have no call of their own, with words on standard error."""

from __future__ import annotations

from argparse import Namespace

from hotlap.api import scenarios
from hotlap.cli.progress import TERMINAL
from hotlap.core.parameters import Parameters
from hotlap.race.controller_kind import ControllerKind
from hotlap.race.race import Race
from hotlap.reference.scenario import Scenario
from hotlap.worlds.world import World


def load(options: Namespace) -> Race:
    """The race that was asked for, with the controller that was asked for."""
    return scenarios.load(options.race, options.controller)


def make_ready(world: World, scenario: Scenario) -> None:
    """Let a world compile what it flies with, and say so where that takes its time."""
    scenarios.make_ready(world, scenario, TERMINAL)


def make_kind_ready(world: World, kind: ControllerKind) -> None:
    """The same where no scenario is at hand yet: for any race that a kind of controller flies."""
    scenarios.make_kind_ready(world, kind, TERMINAL)


def read_guess(text: str, scenario: Scenario) -> Parameters:
    """The first guess that was asked for, shape (S, K): a name, parameters, or what is learnt from a training set."""
    return scenarios.read_guess(text, scenario, TERMINAL)
