"""Snapshot: everything that is recorded of a study, read at one moment."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hotlap.core.ledger import Ledger
from hotlap.core.parameters import Parameters
from hotlap.core.shown import Shown
from hotlap.study.configuration import GIVEN, Configuration
from hotlap.study.result import Result
from hotlap.study.study import Study
from hotlap.study.tried_plan import TriedPlan, describe_choice

ELSEWHERE = Path("transfer") / "page.html"
"""The page about flights in other worlds, in the folder of a study; there may be none."""


@dataclass(frozen=True, repr=False)
class Snapshot(Shown):
    """A study as it was at one moment.

    Attributes:
        folder: of the study.
        configuration: what is tuned, and how.
        result: so far; None before the first flight.
        finished: whether the search is over and its result validated.
        ledger: all flights.
        openings: when it was worked on, with the versions of what worked.
        command: that began it.
        hold: conditions that its result is to hold under, as they were asked for.
        advice: what to try where its result is not confirmed, beside what flights say.
        plans: that were tried before one was chosen; empty where the race fixes it.
    """

    folder: Path
    configuration: Configuration
    result: Result | None
    finished: bool
    ledger: Ledger
    openings: tuple[tuple[str, Mapping[str, str]], ...]
    command: str
    hold: str = ""
    advice: tuple[str, ...] = ()
    plans: tuple[TriedPlan, ...] = ()

    @property
    def remark(self) -> str:
        """Which plan was chosen, where one was, the tuner's own remark, and where to read how it flew elsewhere."""
        elsewhere = f"Flown in other worlds, too: {ELSEWHERE}" if (self.folder / ELSEWHERE).is_file() else ""
        several = (
            "Flown by several versions of hotlap's source code" if len({str(words.get("code")) for _, words in self.openings}) > 1 else ""
        )
        told = describe_choice(self.plans), several, "" if self.result is None else self.result.remark, elsewhere
        return ". ".join(part for part in told if part)

    @property
    def best(self) -> Parameters:
        """The best parameters so far, shape (S, K); the first guess before the first flight."""
        return self.configuration.first_guess if self.result is None else self.result.best.parameters


def read_snapshot(study: Study) -> Snapshot:
    """Read a study as it is now, also while another process works on it."""
    configuration = study.configuration
    with study.at_one_moment():
        tuning = study.tuning
        return Snapshot(
            folder=study.folder,
            configuration=configuration,
            result=study.result,
            finished=tuning.best is not None and tuning.done,
            ledger=study.flights(),
            openings=tuple(study.openings),
            command=study.command or _rebuild(configuration, study.hold),
            hold=study.hold,
            advice=tuple(study.advice),
            plans=tuple(study.plans),
        )


def _rebuild(configuration: Configuration, hold: str) -> str:
    """A command that does the same, for a study that was begun by a program; what a command cannot say is left out."""
    settings = configuration.settings
    words = ["hotlap", "tune", configuration.scenario.race.name, "--tuner", configuration.tuner, "--goal", str(settings.goal)]
    words += ["--budget", str(settings.budget), "--seed", str(settings.seed)]
    words += ["--hold", hold] if hold else []
    name = "default" if begins_at_default(configuration) else configuration.first_guess_name
    return shlex.join(words if name == GIVEN or configuration.rival is not None else [*words, "--first-guess", name])


def begins_at_default(configuration: Configuration) -> bool:
    """Whether the first guess is the controller's default in every segment."""
    first = configuration.first_guess
    return np.array_equal(first, configuration.scenario.space.first_guess(len(first)))
