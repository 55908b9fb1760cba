"""Checked: what a file means; a race is planned and flown with weights that nobody has tuned."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hotlap import worlds
from hotlap.api.asked import Asked
from hotlap.api.first_flights import describe_flights
from hotlap.api.held import dump_margin
from hotlap.api.inputs import as_path, check_range, check_source
from hotlap.api.outcome import Outcome
from hotlap.api.scenarios import load as load_race
from hotlap.api.scenarios import make_ready, make_scenario
from hotlap.core.errors import InputError, PlanningError
from hotlap.feasibility import Finding, Level, describe
from hotlap.feasibility.explanation import describe_margins
from hotlap.feasibility.flown import describe_flown
from hotlap.feasibility.margins import Margin, margins
from hotlap.feasibility.race import describe_race
from hotlap.files.descriptions import Description, Kind, load
from hotlap.files.recognition import TYPES
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import Race
from hotlap.race.track import Track
from hotlap.reference.scenario import Scenario

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_FLIGHTS = 10_000


@dataclass(frozen=True, repr=False)
class CheckedFile(Outcome):
    """What a track, a quadrotor or a race means.

    Attributes:
        description: as it was read.
        findings: in the order in which one would ask.
        margins: of thrust and rates: of a race with a plan as it is, then under conditions that cost thrust.
    """

    description: Description
    findings: tuple[Finding, ...]
    margins: tuple[Margin, ...] = ()

    @property
    def kind(self) -> Kind:
        """What it describes."""
        return next(kind for kind, described in TYPES.items() if isinstance(self.description, described))

    @property
    def warned(self) -> bool:
        """Whether there is a warning among the findings."""
        return any(finding.level is Level.WARNING for finding in self.findings)

    def facts(self) -> dict[str, str]:
        """Name and warnings."""
        warnings = {finding.label: f"{finding.value} {finding.remark}" for finding in self.findings if finding.level is Level.WARNING}
        return {"kind": f"{self.kind} {self.description.name}", **warnings}

    def rows(self) -> list[dict[str, Any]]:
        """A row for each finding."""
        return [{**_words(one), "level": one.level.value, "figures": dict(one.figures)} for one in self.findings]

    def to_dict(self) -> dict[str, Any]:
        """The keys of `hotlap check --json`."""
        left = [{"condition": one.condition.name, **(dump_margin(one) or {})} for one in self.margins]
        return {"kind": self.kind.value, "name": self.description.name, "findings": self.rows(), "margins": left}

    def plot(self) -> Figure:
        """Nothing: a plan can be drawn.

        Raises:
            InputError: always.
        """
        raise InputError("", "plot", "findings are words; hotlap.plan(RACE).plot() draws a race")


def _words(finding: Finding) -> dict[str, str]:
    """What a finding says to people."""
    return {"label": finding.label, "value": finding.value, "remark": finding.remark}


def carry_out(asked: Asked) -> CheckedFile:
    """Check what was asked for, the quick things first; plan and fly a race."""
    check_range("flights", asked.flights, 0, MOST_FLIGHTS)
    check_source(as_path(asked.reference))
    description = asked.file if isinstance(asked.file, Track | Quadrotor | Race) else load(asked.file)
    if not isinstance(description, Race):
        _refuse_of_a_race(asked, "track" if isinstance(description, Track) else "quadrotor")
        return CheckedFile(description, describe(description))
    race = load_race(description, asked.controller)
    try:
        scenario = make_scenario(race, asked)
    except PlanningError as error:
        return CheckedFile(race, (*describe_race(race), Finding("no plan", "none", str(error), Level.WARNING)))
    left = margins(race, scenario.reference, offset_free=scenario.offset_free)
    return CheckedFile(race, tuple(_describe(scenario, left, asked)), left)


def _refuse_of_a_race(asked: Asked, kind: str) -> None:
    """Refuse what only a race has."""
    for name in ("reference", "controller"):
        if getattr(asked, name) is not None:
            raise InputError("", name, f"is of a race, not of a {kind}")


def _describe(scenario: Scenario, left: Sequence[Margin], asked: Asked) -> Iterator[Finding]:
    """What a race means: figures first, then its plan, then its flights."""
    race, planned = scenario.race, asked.reference is None
    file = "" if planned else Path(asked.reference).name
    yield from describe_race(race, scenario.reference.max_speed, planned=planned)
    yield from (Finding("assumed", file, note.removeprefix(f"{asked.reference}: "), Level.NOTE) for note in scenario.notes)
    yield from describe_flown(race, scenario.reference, file)
    yield from describe_margins(race, scenario.reference, left, planned=planned)
    if asked.flights:
        world = worlds.build("built-in")
        make_ready(world, scenario, asked.progress)
        yield from describe_flights(scenario, world, asked.flights, (lambda slower: make_scenario(slower, asked)) if planned else None)
