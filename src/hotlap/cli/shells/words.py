"""Words: what may follow what on the command line, for the scripts of all shells."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

from hotlap import tuners
from hotlap.cli.arguments import COMMANDS
from hotlap.cli.parser import OneOf, path
from hotlap.core.vehicle_names import LANGUAGES
from hotlap.core.world_names import BUILT_IN, SIMULATORS
from hotlap.files.descriptions import names
from hotlap.files.kinds import Kind
from hotlap.files.suites import SUITES
from hotlap.first_guess.names import NAMES as GUESSES

LONGEST = 70  # characters of a help
FOLDER = "DIR"  # the metavar of folders
FILES = frozenset({"FILE", "LOG"})  # metavars of files
LISTS = frozenset({"tuners", "to"})  # arguments whose words are joined by commas
EITHER = frozenset({"race", "races", "track", "vehicle", "first_guess", "cluster", "quadrotor"})  # arguments that are names or files


@dataclass(frozen=True)
class Argument:
    """An argument of a command.

    Attributes:
        options: that name it; none: it has a place instead.
        meaning: a few words.
        metavar: what stands for its value; "" where it takes none.
        words: some values, or all.
        files: whether a file may be one.
        folders: whether a folder may be one, and no file.
        joined: whether values are joined by commas.
    """

    options: tuple[str, ...]
    meaning: str
    metavar: str
    words: tuple[str, ...]
    files: bool = False
    folders: bool = False
    joined: bool = False


@dataclass(frozen=True)
class CommandWords:
    """A command.

    Attributes:
        name: as it is called.
        purpose: one clause.
        options: with their values.
        places: what may stand without an option, whichever place it has.
    """

    name: str
    purpose: str
    options: tuple[Argument, ...]
    places: Argument


@cache
def commands() -> tuple[CommandWords, ...]:
    """Every command of `hotlap`."""
    found = []
    for name, command in COMMANDS.items():
        arguments = [_argument(name, action) for action in command.parser(name).arguments]
        placed = [one for one in arguments if not one.options]
        words = tuple(dict.fromkeys(word for one in placed for word in one.words))
        files, folders = any(one.files for one in placed), any(one.folders for one in placed)
        places = Argument((), "", "", words, files, folders and not files)
        found.append(CommandWords(name, command.purpose, tuple(one for one in arguments if one.options), places))
    return tuple(found)


def _argument(command: str, action: argparse.Action) -> Argument:
    """An argument of a parser."""
    takes = action.nargs != 0
    folders = takes and action.metavar == FOLDER
    words = _words(command, action) if takes else ()
    return Argument(
        options=tuple(action.option_strings),
        meaning=_shorten(action.help or ""),
        metavar=str(action.metavar) if takes else "",
        words=words,
        files=takes and not folders and (action.type is path or action.dest in EITHER or action.metavar in FILES),
        folders=folders,
        joined=action.dest in LISTS,
    )


def _words(command: str, action: argparse.Action) -> tuple[str, ...]:
    """Values that are known of an argument."""
    if isinstance(action.type, OneOf):
        return tuple(map(str, action.type.names))
    if action.dest == "file" and command == "check":
        return tuple(name for kind in Kind for name in names(kind))
    if action.dest == "on" and command == "lap":
        return tuple(f"{language}:" for language in LANGUAGES)
    known = LISTED.get(command) if action.dest == "names" else NAMED.get(action.dest)
    return known() if known else ()


def _shorten(text: str) -> str:
    """The first clause of a help."""
    clause = re.split(r"[;(]|: ", text, maxsplit=1)[0].strip()
    return clause if len(clause) <= LONGEST else clause[: LONGEST - 4].rpartition(" ")[0] + " ..."


def _races() -> tuple[str, ...]:
    return names(Kind.RACE)


def _tracks() -> tuple[str, ...]:
    return names(Kind.TRACK)


def _quadrotors() -> tuple[str, ...]:
    return names(Kind.QUADROTOR)


def _tuners() -> tuple[str, ...]:
    """Algorithms, then each with its presets."""
    every = tuners.names()
    return (*dict.fromkeys(name.partition(":")[0] for name in every), *every)


def _worlds() -> tuple[str, ...]:
    return (BUILT_IN, *SIMULATORS)


NAMED: Mapping[str, Callable[[], tuple[str, ...]]] = {  # by argument, what its values may be
    "race": _races,
    "races": _races,
    "track": _tracks,
    "vehicle": _quadrotors,
    "quadrotor": _quadrotors,
    "tuner": _tuners,
    "tuners": _tuners,
    "on": _worlds,
    "to": _worlds,
    "first_guess": lambda: tuple(GUESSES),
}
LISTED: Mapping[str, Callable[[], tuple[str, ...]]] = {  # by command that lists, what may be asked for
    "races": lambda: (*_races(), *SUITES),
    "tracks": _tracks,
    "quadrotors": _quadrotors,
    "tuners": _tuners,
    "worlds": _worlds,
}
