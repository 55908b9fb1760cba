"""Glance: what there is to say of a study in one row, read without its flights, its reference or its tuner.

Hundreds of studies can be followed like that: a study whose file has not changed is not opened, and of one that has, only the batches
since the last look are read.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

from hotlap.core.errors import StudyError
from hotlap.study.checksums import checksum
from hotlap.study.database import FILE, Database
from hotlap.study.increments import INSIDE, VALUE, grow
from hotlap.system.folder_lock import holder_of
from hotlap.tuning.goal import Quantity, parse_goal
from hotlap.tuning.settings import TuningSettings

DEEPEST = 3  # folders below the one that is looked at
KEPT = ("best", "validation", "ended", "flown")  # of the state of a run


class State(StrEnum):
    """How far a study is: at work, left before its end, or at its end with its goal confirmed or not, or without a goal."""

    SEARCHING = "searching"
    STOPPED = "stopped"
    CONFIRMED = "confirmed"
    NOT_SOLVED = "not solved"
    FINISHED = "finished"
    UNREADABLE = "unreadable"


@dataclass(frozen=True)
class Glance:
    """A study at one moment.

    Attributes:
        name: its folder, as seen from the one that is looked at.
        state: how far it is.
        race, tuner, world, goal: what is tuned, by what, where, to what end; "" where it cannot be read.
        seed: of the run.
        budget: flights that it may take; 0 where minutes are counted.
        minutes: of its search; 0 where flights are counted.
        flights: of the search so far, re-flights included.
        completion: of the best candidate so far, 0 to 1; NaN before the first flight.
        lap_time: [s] of the same; NaN where there is none.
        successes, validation: of its validation, 0 of 0 before it.
        kept: whether its result is what its search began with.
        changed: [s] since the epoch, when its file was written last.
        fault: why it cannot be read.
    """

    name: str
    state: State
    race: str = ""
    tuner: str = ""
    world: str = ""
    goal: str = ""
    seed: int = 0
    budget: int = 0
    minutes: float = 0.0
    flights: int = 0
    completion: float = math.nan
    lap_time: float = math.nan
    successes: int = 0
    validation: int = 0
    kept: bool = False
    changed: float = 0.0
    fault: str = ""


def find_studies(folder: Path) -> Iterator[Path]:
    """Folders of studies in a folder and below it; nothing is sought inside of a study.

    Args:
        folder: one that cannot be read holds none.
    """
    for root, below, files in os.walk(folder):
        if FILE in files:
            yield Path(root)
            below.clear()
        elif len(Path(root).relative_to(folder).parts) >= DEEPEST:
            below.clear()
        below.sort()


class Follower:
    """Follows one study.

    Args:
        folder: of the study.
        name: what it is called.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self.folder, self.name = folder, name
        self._seen: tuple[int, int] | None = None
        self._row, self._digest = 0, 0
        self._state: dict[str, Any] = {}
        self._asked: dict[str, Any] = {}
        self._glance = Glance(name, State.UNREADABLE)

    def look(self) -> Glance:
        """The study as it is now; the same object where nothing has changed."""
        try:
            found = (self.folder / FILE).stat()
        except OSError as error:
            return Glance(self.name, State.UNREADABLE, fault=f"{FILE}: {error.strerror}")
        if self._seen != (found.st_mtime_ns, found.st_size):
            try:
                self._read_again()
            except StudyError as error:
                self._glance = Glance(self.name, State.UNREADABLE, fault=error.reason)
            self._glance = replace(self._glance, changed=found.st_mtime)
            self._seen = found.st_mtime_ns, found.st_size
        if self._glance.state in {State.SEARCHING, State.STOPPED}:
            state = State.SEARCHING if _is_worked_on(self.folder) else State.STOPPED
            self._glance = self._glance if state is self._glance.state else replace(self._glance, state=state)
        return self._glance

    def _read_again(self) -> None:
        """What is new in the file, or all of it where another study has taken its place."""
        try:
            self._read()
        except StudyError:
            if not self._row:
                raise
            self._row, self._digest, self._state = 0, 0, {}
            self._read()

    def _read(self) -> None:
        """Whatever is new in the file."""
        database = Database(self.folder, owned=False)
        try:
            if database.is_new(checked=False):  # to check all of the file would be to read all of it
                raise StudyError(str(self.folder), "", f"{FILE} holds no study")
            with database.at_one_moment():
                asked = database.rows("entry", where="key = 'configuration'", order="key")
                changes = database.rows("increment", where="rowid > ?", values=(self._row,), before=self._digest)
            with database.decoding("what was asked for, or its state,"):
                self._asked = json.loads(asked[0][1])
                for (change,) in changes:
                    self._state = _projected(self._state, json.loads(change))
                    self._row, self._digest = self._row + 1, checksum((change,), self._digest)
                self._glance = self._summary()
        finally:
            database.close()

    def _summary(self) -> Glance:
        asked, best, validation = self._asked, self._state.get("best") or {}, self._state.get("validation") or {}
        flown = self._state.get("flown", {})
        completion, lap_time = (math.nan if best.get(name) is None else best[name] for name in ("completion", "lap_time"))
        glance = Glance(
            name=self.name,
            state=State.STOPPED,
            race=asked["race"]["name"],
            tuner=asked["tuner"]["name"],
            world=asked["world"],
            goal=asked["goal"],
            seed=asked["seed"],
            budget=0 if asked["minutes"] else asked["budget"],
            minutes=asked["minutes"] or 0.0,
            flights=flown.get("SEARCH", 0) + flown.get("CONFIRMATION", 0),
            successes=validation.get("successes", 0),
            validation=validation.get("flights", 0),
            kept=bool(best.get("confirmed") and best["parameters"] in (asked["first_guess"], asked.get("rival"))),
            completion=completion,
            lap_time=lap_time,
        )
        if not self._is_done(glance):
            return glance
        if parse_goal(asked["goal"]).quantity is Quantity.NONE:
            return replace(glance, state=State.FINISHED)
        return replace(glance, state=State.CONFIRMED if best.get("confirmed") else State.NOT_SOLVED)

    def _is_done(self, glance: Glance) -> bool:
        """Whether the search is over, and its result validated where that is asked for."""
        best, asked = self._state.get("best"), self._asked
        each = TuningSettings(**{name: asked[name] for name in ("samples", "randomise", "minutes") if name in asked}).flights_each
        over = best and (best["confirmed"] or self._state.get("ended") or asked["budget"] - glance.flights < each)
        return bool(over and (self._state.get("validation") or not asked["validation"]))


def _projected(before: Mapping[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
    """`KEPT` of a state after an increment; the rest, which holds all that a tuner knows, is dropped unread."""
    if INSIDE in change:
        inner = {key: part for key, part in change[INSIDE].items() if key in KEPT}
        return grow(dict(before), {INSIDE: inner})
    return {key: value for key, value in change[VALUE].items() if key in KEPT}


def _is_worked_on(folder: Path) -> bool:
    """Whether the process that locked the folder last is still there."""
    process = holder_of(folder)
    with suppress(OSError, OverflowError):
        if process > 0:
            os.kill(process, 0)
            return True
    return False
