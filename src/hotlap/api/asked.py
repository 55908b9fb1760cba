"""Asked: the arguments of a call, and the command line that asks for the same."""

from __future__ import annotations

import inspect
import shlex
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from hotlap.api.progress import Quiet

NAMELESS = ("progress", "cache")  # arguments that no recorded command has


class Asked(SimpleNamespace):
    """The arguments of a call by their names, as they were given; without `progress`, one that says nothing.

    Args:
        call: the function that was called.
        given: all its arguments.
    """

    def __init__(self, call: Callable[..., Any], given: Mapping[str, Any]) -> None:
        super().__init__(**given)
        if getattr(self, "progress", None) is None:
            self.progress = Quiet()
        self._call = call

    def command(self, **changed: Any) -> str:
        """The command line that does the same; "" where something that was given, as a `Race`, has no name there.

        Args:
            changed: arguments in place of those that were given.
        """
        return command_line(self._call, {**vars(self), **changed})

    @contextmanager
    def remarked(self, does: str, **changed: Any) -> Iterator[None]:
        """Whatever stops the work within says how to go on.

        Args:
            does: what the command does: "go on".
            changed: arguments of that command in place of those that were given.
        """
        try:
            yield
        except BaseException as error:
            command = self.command(**changed)
            again = command or f"the same call{''.join(f', {name}={str(value)!r}' for name, value in changed.items())}"
            error.add_note(f"nothing is lost; {does} with: {again}")
            raise


def command_line(call: Callable[..., Any], given: Mapping[str, Any]) -> str:
    """The command line of a call, with what differs from the defaults; "" where something has no name there.

    Args:
        call: a function whose name is that of the command.
        given: some of its arguments; those that are left out have their defaults.
    """
    words, last = ["hotlap", call.__name__], list[str]()
    for name, parameter in inspect.signature(call).parameters.items():
        value = given.get(name, parameter.default)
        if name in NAMELESS or value == parameter.default:
            continue
        values = value if isinstance(value, list | tuple) else [value]
        if not all(isinstance(one, str | int | float | Path) for one in values):
            return ""
        if parameter.kind is parameter.POSITIONAL_OR_KEYWORD:
            words += map(str, values)
        else:
            option = [f"--{name.replace('_', '-')}", ",".join(map(str, values))]
            last, words = (option, words) if name == "out" else (last, words + option)
    return shlex.join(words + last)
