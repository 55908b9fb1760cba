"""Asked: the arguments of a call, and the command line that asks for the same."""

from __future__ import annotations

import inspect
import shlex
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from hotlap.api.given import as_annotated
from hotlap.api.notebook import progress_of

NAMELESS = ("progress", "cache")  # arguments that no recorded command has
WINDOW = "window"  # argument that is two options of a command


class Asked(SimpleNamespace):
    """The arguments of a call by their names, as they were given; without `progress`, one that shows bars in a notebook alone.

    Args:
        call: the function that was called.
        given: all its arguments.

    Raises:
        InputError: an argument is of another type than the call's signature says.
    """

    def __init__(self, call: Callable[..., Any], given: Mapping[str, Any]) -> None:
        super().__init__(**as_annotated(call, given))
        self.progress = progress_of(getattr(self, "progress", None))
        self._call = call

    def command(self, **changed: Any) -> str:
        """The command line that does the same; "" where something that was given, as a `Race`, has no name there.

        Args:
            changed: arguments in place of those that were given.
        """
        return command_line(self._call, {**vars(self), **changed})

    def code(self, **changed: Any) -> str:
        """The call that does the same; where something that was given has no text, such as a `Race`, what differs from it.

        Args:
            changed: arguments in place of those that were given.
        """
        if not self.command(**changed):
            return f"the same call{''.join(f', {name}={str(value)!r}' for name, value in changed.items())}"
        given, words = {**vars(self), **changed}, list[str]()
        for name, parameter in inspect.signature(self._call).parameters.items():
            value = given.get(name, parameter.default)
            if name in NAMELESS or value == parameter.default:
                continue
            plain = [str(one) if isinstance(one, Path) else one for one in (value if isinstance(value, list | tuple) else [value])]
            shown = repr(plain if isinstance(value, list | tuple) else plain[0])
            words.append(shown if parameter.kind is parameter.POSITIONAL_OR_KEYWORD else f"{name}={shown}")
        words.sort(key=lambda word: word.startswith("out="))  # last, as it is looked for there
        return f"hotlap.{self._call.__name__}({', '.join(words)})"

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
            error.add_note(f"nothing is lost; {does} with: {self.code(**changed)}")
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
        if isinstance(value, bool):
            words.append(f"--{'' if value else 'no-'}{name.replace('_', '-')}")
            continue
        if name == WINDOW:
            words += [word for side, one in zip(("--from", "--to"), value, strict=True) if one is not None for word in (side, f"{one:g}")]
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
