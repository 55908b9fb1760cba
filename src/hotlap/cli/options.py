"""Options: what a call of `hotlap.api` takes as arguments of a command, read from its signature and its docstring."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from hotlap.api.asked import WINDOW
from hotlap.cli.parser import Parser, duration, fraction, number, one_of, path, whole
from hotlap.core.world_names import BUILT_IN, OWN, SIMULATORS
from hotlap.exporters.formats import FORMATS
from hotlap.first_guess.names import NAMES as GUESSES
from hotlap.race.controller_kind import ControllerKind
from hotlap.reference.segmentation_rule import SegmentationRule
from hotlap.tuning.goal_forms import FORMS

SEVERAL = ("races", "logs")  # arguments of which several may be given
WINDOW_OPTIONS = {"from": "seconds of the log's clock before which nothing counts", "to": "and after which nothing counts"}
ONLY_IN_PYTHON = "; in Python"  # what follows it in a docstring is not for the command line
_ARGUMENTS = re.compile(r"^Args:\n(.*?)(?:\n\n|\Z)", re.DOTALL | re.MULTILINE)
_ARGUMENT = re.compile(r"^    (\w+): (.*(?:\n {5,}.*)*)", re.MULTILINE)


@dataclass(frozen=True)
class Shown:
    """What a signature does not say of an argument.

    Attributes:
        metavar: what stands for its value.
        kind: what its values are, where they are names.
        names: all there are; none: any value.
        values: what they may be, in words.
    """

    metavar: str
    kind: str = ""
    names: tuple[str, ...] = ()
    values: str = ""


PARAMETERS = f"{', '.join(GUESSES)}, parameters (a file or a study's folder), or what was learnt (a .json)"
WORLDS = f"{', '.join((BUILT_IN, *SIMULATORS))} or {OWN}, each NAME[:ARGUMENT]"
SHOWN: Mapping[str, Shown] = {
    "race": Shown("RACE"),
    "races": Shown("RACE"),
    "logs": Shown("LOG"),
    "quadrotor": Shown("QUADROTOR"),
    "file": Shown("FILE"),
    "map": Shown("FILE"),
    "start": Shown("S"),
    "folder": Shown("DIR"),
    "goal": Shown("GOAL", values=FORMS),
    "seed": Shown("S"),
    "segments": Shown("RULE", "segmentation rule", tuple(SegmentationRule)),
    "controller": Shown("KIND", "controller", tuple(ControllerKind)),
    "first_guess": Shown("NAME", values=PARAMETERS),
    "format": Shown("NAME", "format", tuple(FORMATS)),
    "on": Shown("WORLD", values=WORLDS),
    "to": Shown("A,B", values=WORLDS),
    "tuners": Shown("A,B"),
    "budget": Shown("N"),
    "randomise": Shown("R"),
    "hold": Shown("LIST"),
    "reliability": Shown("R"),
    "cluster": Shown("ADDRESS"),
}
METAVARS: Mapping[Callable[[str], Any], str] = {path: "FILE", whole: "N", fraction: "R", number: "X", duration: "M", str: "NAME"}


def add_call(parser: Parser, call: Callable[..., Any], **shown: Shown) -> None:
    """Add an argument for every parameter of a call but `progress`, with its default.

    Args:
        parser: of the command.
        call: keyword-only parameters become options, the others positional arguments.
        shown: what is shown of some parameters, in place of `SHOWN`.
    """
    meanings = meanings_of(call)
    for name, parameter in inspect.signature(call).parameters.items():
        if name == WINDOW:
            for side, meaning in WINDOW_OPTIONS.items():
                parser.add_argument(f"--{side}", type=number, metavar="S", help=meaning)
        elif name != "progress":
            _add(parser, parameter, meanings.get(name, ""), shown.get(name, SHOWN.get(name)))


def arguments_of(call: Callable[..., Any], options: Any) -> dict[str, Any]:
    """What was asked for on the command line, by the call's parameters."""
    return {name: _given(options, name) for name in inspect.signature(call).parameters if name != "progress"}


def _given(options: Any, name: str) -> Any:
    """The value of one parameter."""
    if name != WINDOW:
        return getattr(options, name)
    sides = tuple(getattr(options, side) for side in WINDOW_OPTIONS)
    return None if sides == (None, None) else sides


def meanings_of(call: Callable[..., Any]) -> dict[str, str]:
    """What each argument means, by the docstring, as far as it is for the command line."""
    block = _ARGUMENTS.search(inspect.getdoc(call) or "")
    found = _ARGUMENT.findall(block[1]) if block else []
    return {name: " ".join(text.split()).removesuffix(".").partition(ONLY_IN_PYTHON)[0] for name, text in found}


def _add(parser: Parser, parameter: inspect.Parameter, meaning: str, shown: Shown | None) -> None:
    """One argument."""
    option, default = f"--{parameter.name.replace('_', '-')}", parameter.default
    if default is True:
        parser.add_argument(f"--no-{option[2:]}", dest=parameter.name, action="store_false", help=meaning.partition("; False: ")[2])
        return
    if default is False:
        parser.add_argument(option, action="store_true", help=meaning)
        return
    kind = one_of(shown.kind, shown.names) if shown and shown.names else _kind(parameter)
    meaning, found, automatic = meaning.partition(f"; {default!r}: ")
    known = "" if shown is None else shown.values or ", ".join(shown.names)
    settings: dict[str, Any] = {
        "type": kind,
        "metavar": shown.metavar if shown else METAVARS[kind],
        "help": f"{meaning}: {known}" if known else meaning,
    }
    if parameter.kind is not parameter.KEYWORD_ONLY and option != "--format":
        parser.add_argument(parameter.name, **settings, **({"nargs": "+"} if parameter.name in SEVERAL else {}))
    elif default is parameter.empty:
        parser.add_argument(option, required=True, **settings)
    else:
        parser.add_argument(option, default=default, automatic=automatic if found else "", **settings)


def _kind(parameter: inspect.Parameter) -> Callable[[str], Any]:
    """What makes a value of a word."""
    if isinstance(parameter.default, int):
        return whole
    if isinstance(parameter.default, float):
        return duration if parameter.name == "minutes" else fraction
    if str(parameter.annotation).startswith("float"):
        return number
    return path if "Path" in str(parameter.annotation) and "Race" not in str(parameter.annotation) else str
