"""Imported: a description made of another program's file, with what was assumed and what was left out."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hotlap.core.printable import printable
from hotlap.core.shown import Shown
from hotlap.files.error_messages import check
from hotlap.files.kinds import Kind
from hotlap.files.recognition import TYPES
from hotlap.files.toml_writer import write_pair
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.track import Track

WIDTH = 140
DIGITS = 12  # of a number that is written: 0.4 / 2 + 1.0 is 1.2


@dataclass(frozen=True, repr=False)
class Imported(Shown):
    """A track or a quadrotor, as it was found in a file of another program.

    Attributes:
        source: the file.
        format: what it is.
        kind: track or quadrotor.
        table: keys and values of our description.
        taken: what was assumed of it, a sentence each: frames, units, the meaning of a length.
        lost: what could not be carried over, a clause each that begins with the key.
    """

    source: str
    format: str
    kind: Kind
    table: Mapping[str, Any]
    taken: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """What it is called."""
        return str(self.table["name"])

    @property
    def description(self) -> Track | Quadrotor:
        """The description, checked.

        Raises:
            InputError: its numbers cannot be right; with the source, our key and the reason.
        """
        return check(TYPES[self.kind], self.table, self.source)  # pyright: ignore[reportReturnType]  no race is imported

    @property
    def text(self) -> str:
        """The TOML file: what it was made of in comments, then the keys."""
        head = [f"A {self.kind} made by hotlap import from {self.source}: {self.format}."]
        for title, remarks in (("Taken as:", self.taken), ("Not carried over:", self.lost)):
            head += [title, *(f"  {remark}" for remark in remarks)] if remarks else []
        lines = [f"# {part}" for line in head for part in _wrapped(printable(line))]
        return "\n".join([*lines, *(write_pair(key, value) for key, value in self.table.items())]) + "\n"


@dataclass(frozen=True)
class Format:
    """A kind of file of another program.

    Attributes:
        name: of the program and of what the file describes.
        kind: what it describes.
        matches: whether a file is of this kind, by its keys.
        read: its content as a description; the name is what the user wants to call it, or None.
    """

    name: str
    kind: Kind
    matches: Callable[[Any], bool]
    read: Callable[[Any, str | None], Findings]
    xml: bool = False


@dataclass
class Findings:
    """What an importer collects while it reads.

    Attributes:
        table: keys and values of our description.
        taken: what was assumed, a sentence each.
        lost: what could not be carried over, a clause each.
    """

    table: dict[str, Any] = field(default_factory=dict)
    taken: list[str] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)


def rounded(value: Any) -> Any:
    """Numbers without the last digits, in which calculation leaves its traces."""
    if isinstance(value, bool | str | int):
        return value
    if isinstance(value, Mapping):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, Sequence):
        return [rounded(item) for item in value]
    return float(f"{float(value):.{DIGITS}g}")


def _wrapped(line: str) -> list[str]:
    """A line of a comment, broken where it is too long."""
    indent = " " * (len(line) - len(line.lstrip()))
    long = len(line) > WIDTH - 2
    return textwrap.wrap(line.lstrip(), WIDTH - 2, initial_indent=indent, subsequent_indent=indent + "  ") if long else [line]
