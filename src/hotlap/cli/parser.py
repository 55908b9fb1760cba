"""Parser: argparse, with every fault as one line.

Not tyro: it prints its errors as boxes, and hands them out as data only through a module that it declares private and unstable.
"""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import NoReturn

from hotlap.core.errors import InputError, UnknownNameError
from hotlap.core.renamed import say_renamed

HELP = {"-h", "--help"}
RENAMED = {"--worlds": "--samples"}  # options of before
_OF_ARGUMENT = re.compile(r"argument ([^:]+): (.*)", re.DOTALL)
_MISSING = re.compile(r"the following arguments are required: (.*)")


class Parser(argparse.ArgumentParser):
    """A parser of one command; raises instead of printing and exiting.

    Args:
        command: as it is called, `hotlap tune`.
        summary: one sentence.
        examples: lines that show how it is called.
    """

    def __init__(self, command: str, summary: str, examples: Sequence[str] = ()) -> None:
        shown = "\n".join(["examples:", *(f"  {line}" for line in examples)]) if examples else None
        layout = argparse.RawDescriptionHelpFormatter
        super().__init__(command, description=summary, epilog=shown, formatter_class=layout, add_help=False, allow_abbrev=False)
        self.add_argument("-h", "--help", action="store_true", help="show this help")

    def error(self, message: str) -> NoReturn:
        """Argparse's complaint as an error of ours."""
        argument, missing = _OF_ARGUMENT.fullmatch(message), _MISSING.fullmatch(message)
        if missing:
            raise InputError(missing[1], "", f"is missing; see {self.prog} --help")
        if argument:
            raise InputError(argument[1], "", argument[2].replace("expected one argument", "needs a value"))
        raise InputError("", "", message)

    def parse(self, arguments: Sequence[str]) -> argparse.Namespace | None:
        """What was asked for; None where it was help.

        Raises:
            InputError: it cannot be understood.
        """
        arguments = [self._present(argument) for argument in arguments]
        options = arguments[: arguments.index("--")] if "--" in arguments else arguments
        if HELP & set(options):
            return None
        for option in options:
            if option.startswith("--") and option.partition("=")[0] not in self._option_string_actions:
                raise self._unknown(option.partition("=")[0])
        parsed, unknown = self.parse_known_args(arguments)
        if unknown:
            raise self._unknown(unknown[0])
        return parsed

    def _present(self, argument: str) -> str:
        """An option as it is called now; says so where it was a name of before."""
        option, separator, value = argument.partition("=")
        new = RENAMED.get(option)
        if new is None or new not in self._option_string_actions:
            return argument
        say_renamed(option, new)
        return new + separator + value

    def _unknown(self, argument: str) -> InputError:
        """An argument that nothing takes."""
        if not argument.startswith("-"):
            return InputError(argument, "", f"is one argument too many; see {self.prog} --help")
        near = get_close_matches(argument, self._option_string_actions, n=1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        return InputError(argument, "", f"is no option of {self.prog}{hint}; see {self.prog} --help")


def whole(text: str) -> int:
    """A whole number."""
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be a whole number, not '{text}'") from None


def fraction(text: str) -> float:
    """A number from 0 to 1."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"must be a fraction from 0 to 1, not '{text}'")
    return value


def path(text: str) -> Path:
    """A path, which need not exist."""
    if not text.strip() or "\0" in text:
        raise argparse.ArgumentTypeError(f"must be a path, not '{text}'")
    return Path(text).expanduser() if text.startswith("~/") else Path(text)


def one_of(kind: str, names: Sequence[str]) -> Callable[[str], str]:
    """One of some names."""

    def chosen(text: str) -> str:
        """The name, or what would have been right."""
        if text not in names:
            raise argparse.ArgumentTypeError(UnknownNameError(kind, text, names).reason)
        return text

    return chosen
