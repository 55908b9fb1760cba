"""Keys of the files as they are documented: name, unit, meaning and default, read from the descriptions themselves."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum
from types import UnionType
from typing import Any, get_args

from hotlap.race.schema import Described

_ENTRY = re.compile(r"^ {4,8}(\w+): (.*)$")
_UNIT = re.compile(r"^\[([^\]]+)\]\s*")


@dataclass(frozen=True)
class Key:
    """One key of a file.

    Attributes:
        name: as it is written.
        unit: "" where it has none; "-" where it is a plain number.
        meaning: one sentence.
        required: whether a file must have it.
        default: what holds without it; None: see `meaning`.
        table: the description of its table, or None where it is a value.
    """

    name: str
    unit: str
    meaning: str
    required: bool
    default: Any
    table: type[Described] | None


def documented_keys(description: type[Described]) -> tuple[Key, ...]:
    """The keys of a description, in order."""
    meanings = _meanings(description.__doc__ or "")
    keys = []
    for name, field in description.model_fields.items():
        text = meanings.get(name, "")
        unit = _UNIT.match(text)
        default = None if field.is_required() else field.get_default(call_default_factory=True, validated_data={})
        meaning = _UNIT.sub("", text).rstrip(".").replace("None: ", "Without it: ")
        if isinstance(default, StrEnum):
            meaning += f": {', '.join(type(default))}"
        keys.append(Key(name, unit[1] if unit else "", meaning, field.is_required(), default, table_of(description, name)))
    return tuple(keys)


def table_of(description: type[Described], name: str) -> type[Described] | None:
    """The description that a key's value, or each of its items, has to satisfy; None for plain values."""
    field = description.model_fields.get(name)
    candidates = [field.annotation] if field else []
    while candidates:
        candidate = candidates.pop()
        if isinstance(candidate, type) and not isinstance(candidate, UnionType) and issubclass(candidate, Described):
            return candidate
        candidates += get_args(candidate)
    return None


def _meanings(docstring: str) -> dict[str, str]:
    """The entries below `Attributes:`; an indented line continues the entry above it."""
    entries: dict[str, str] = {}
    name = ""
    for line in docstring.partition("Attributes:")[2].splitlines():
        entry = _ENTRY.match(line)
        if entry:
            name = entry[1]
            entries[name] = entry[2]
        elif name and line.strip():
            entries[name] += " " + line.strip()
    return entries
