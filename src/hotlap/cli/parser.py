"""Parser: argparse, with every fault as one line.

Not tyro: it prints its errors as boxes, and hands them out as data only through a module that it declares private and unstable.
"""

from __future__ import annotations

import argparse
import math
import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NoReturn

from hotlap.core.errors import InputError, UnknownNameError
from hotlap.core.renamed import say_renamed

HELP = {"-h", "--help"}
EXAMPLES = "examples:"
NARROWEST = 20  # columns of prose
_NEGATIVES = re.compile(r"-[\d.]+,")
RENAMED = {"--worlds": "--samples"}  # options of before


class Help(argparse.RawDescriptionHelpFormatter):
    """Help as wide as the terminal, in which a per cent sign is one: defaults are in the text already."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        """Prose is broken where lines end; examples are left as they are, to be copied."""
        if text.startswith(EXAMPLES):
            return super()._fill_text(text, width, indent)
        return wrapped(text, width, indent)

    def _get_help_string(self, action: argparse.Action) -> str:
        return (action.help or "").replace("%", "%%")


class Parser(argparse.ArgumentParser):
    """A parser of one command; raises instead of printing and exiting.

    Args:
        command: as it is called, `hotlap tune`.
        summary: one sentence.
        examples: lines that show how it is called.

    Attributes:
        arguments: all that it takes, in the order in which they were added.
    """

    def __init__(self, command: str, summary: str, examples: Sequence[str] = ()) -> None:
        shown = "\n".join([EXAMPLES, *(f"  {line}" for line in examples)]) if examples else None
        self.arguments: list[argparse.Action] = []
        self._stands_for: dict[str, str] = {}
        super().__init__(
            command,
            description=summary,
            epilog=shown,
            formatter_class=Help,
            add_help=False,
            allow_abbrev=False,
            exit_on_error=False,
        )
        self.add_argument("-h", "--help", action="store_true", help="show this help")

    def add_argument(self, *names: str, automatic: str = "", stands_for: str = "", **settings: Any) -> argparse.Action:
        """The same as argparse's, with the default said in the help.

        Args:
            names: of the argument.
            automatic: what the default means, where the value itself says nothing.
            stands_for: another argument, which need not be given where this one is.
            settings: as argparse takes them.

        Returns:
            The argument, which is remembered, too: argparse has no list of them that is public.
        """
        default = settings.get("default")
        shown = automatic or ("" if default is None else f"{default:g}" if isinstance(default, float) else str(default))
        action = super().add_argument(*names, **settings)
        action.help = f"{action.help} (default: {shown})" if shown else action.help
        self.arguments.append(action)
        if stands_for:
            self._stands_for[stands_for] = action.dest
        return action

    @property
    def options(self) -> dict[str, argparse.Action]:
        """Arguments by each of the options that name them, `--budget`."""
        return {option: action for action in self.arguments for option in action.option_strings}

    def error(self, message: str) -> NoReturn:
        """Whatever argparse complains about other than by an `ArgumentError`."""
        raise InputError("", "", message)

    def parse(self, arguments: Sequence[str]) -> argparse.Namespace | None:
        """What was asked for; None where it was help.

        Raises:
            InputError: it cannot be understood.
        """
        arguments = self._with_negatives([self._present(argument) for argument in arguments])
        options = arguments[: arguments.index("--")] if "--" in arguments else arguments
        if HELP & set(options):
            return None
        for option in options:
            if option.startswith("--") and option.partition("=")[0] not in self.options:
                raise self._unknown(option.partition("=")[0])
        parsed, unknown = self._understand(arguments)
        if unknown:
            raise self._unknown(unknown[0])
        return parsed

    def as_option(self, error: InputError) -> InputError:
        """An error about an argument of a function, as one about the option of the same name; any other as it is."""
        option = next((option for option, action in self.options.items() if action.dest == error.key), "")
        return error if error.source or not option else InputError(option, "", error.reason)

    def _understand(self, arguments: Sequence[str]) -> tuple[argparse.Namespace, list[str]]:
        """Values, and what nothing takes; whether all that is required is there, argparse could say in words alone."""
        required = [action for action in self.arguments if action.required]
        for action in required:
            action.required = False
        try:
            parsed, unknown = self.parse_known_args(arguments)
        except argparse.ArgumentError as error:
            reason = error.message.replace("expected one argument", "needs a value")  # plainer
            raise InputError(error.argument_name or "", "", reason) from None
        finally:
            for action in required:
                action.required = True
        given = {name for name, other in self._stands_for.items() if getattr(parsed, other) is not None}
        missing = [action for action in required if getattr(parsed, action.dest) is None and action.dest not in given]
        if missing:
            names = ", ".join(map(_written, missing))
            raise InputError(names, "", f"is missing; see {self.prog} --help")
        return parsed, unknown

    def _with_negatives(self, arguments: list[str]) -> list[str]:
        """Arguments in which a list that begins with a negative number, -1,2, stands behind its option: argparse takes it for an option."""
        joined: list[str] = []
        for argument in arguments:
            before = self.options.get(joined[-1]) if joined else None
            if before is not None and before.nargs != 0 and _NEGATIVES.match(argument):
                joined[-1] += f"={argument}"
            else:
                joined.append(argument)
        return joined

    def _present(self, argument: str) -> str:
        """An option as it is called now; says so where it was a name of before."""
        option, separator, value = argument.partition("=")
        new = RENAMED.get(option)
        if new is None or new not in self.options:
            return argument
        say_renamed(option, new)
        return new + separator + value

    def _unknown(self, argument: str) -> InputError:
        """An argument that nothing takes."""
        if not argument.startswith("-"):
            return InputError(argument, "", f"is one argument too many; see {self.prog} --help")
        near = get_close_matches(argument, self.options, n=1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        return InputError(argument, "", f"is no option of {self.prog}{hint}; see {self.prog} --help")


def wrapped(text: str, width: int, indent: str = "", first: str | None = None) -> str:
    """A text broken into lines of at most so many columns, none where an option's words have a hyphen.

    Args:
        text: line breaks in it are blanks.
        width: columns.
        indent: of every line.
        first: of the first line; None: the same.
    """
    words, width = " ".join(text.split()), max(width, NARROWEST)
    start = indent if first is None else first
    return textwrap.fill(words, width, initial_indent=start, subsequent_indent=indent, break_on_hyphens=False, break_long_words=False)


def _written(action: argparse.Action) -> str:
    """An argument as the usage calls it."""
    return action.option_strings[-1] if action.option_strings else str(action.metavar)


def whole(text: str) -> int:
    """A whole number."""
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be a whole number, not '{text}'") from None


def fraction(text: str) -> float:
    """A number from 0 to 1."""
    value = _number(text)
    if not 0 <= value <= 1:
        share = _number(text.removesuffix("%")) / 100
        hint = f" (did you mean {share:g}?)" if 0 <= share <= 1 else ""
        raise argparse.ArgumentTypeError(f"must be a fraction from 0 to 1, not '{text}'{hint}")
    return value


def number(text: str) -> float:
    """A number."""
    value = _number(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"must be a number, not '{text}'")
    return value


def duration(text: str) -> float:
    """A time that is not negative."""
    value = _number(text)
    if not 0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"must be a time of 0 or more, not '{text}'")
    return value


def _number(text: str) -> float:
    """A number, NaN where it is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def path(text: str) -> Path:
    """A path, which need not exist."""
    if not text.strip() or "\0" in text:
        raise argparse.ArgumentTypeError(f"must be a path, not '{text}'")
    return Path(text).expanduser() if text.startswith("~/") else Path(text)


@dataclass(frozen=True)
class OneOf:
    """What takes one of some names.

    Attributes:
        kind: what they are names of.
        names: all there are.
    """

    kind: str
    names: Sequence[str]

    def __call__(self, text: str) -> str:
        """The name, or what would have been right."""
        if text not in self.names:
            raise argparse.ArgumentTypeError(UnknownNameError(self.kind, text, self.names).reason)
        return text


def one_of(kind: str, names: Sequence[str]) -> OneOf:
    """One of some names."""
    return OneOf(kind, names)
