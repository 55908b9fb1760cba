"""Documented keys: name, unit, meaning and default of every key of a file, read from the classes that describe the file."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum
from types import UnionType
from typing import Any, get_args

from hotlap.race.schema import Described

_UNIT = re.compile(r"^\[([^\]]+)\]\s*")


@dataclass(frozen=True)
class Key:
    """One key of a file.

    Attributes:
        name: as it is written.
        unit: "" where it has none; "-" where it is a plain number.
        meaning: one sentence.
        required: whether a file must have it.
        default: value where the file does not have the key; None: see `meaning`.
        table: the class that describes its table; None where the key has a plain value.
    """

    name: str
    unit: str
    meaning: str
    required: bool
    default: Any
    table: type[Described] | None


def documented_keys(description: type[Described]) -> tuple[Key, ...]:
    """The keys of a description in the order in which they are declared, from the docstrings below its fields."""
    keys = []
    for name, field in description.model_fields.items():
        text = " ".join((field.description or "").split())
        unit = _UNIT.match(text)
        default = None if field.is_required() else field.get_default(call_default_factory=True, validated_data={})
        meaning = _UNIT.sub("", text).rstrip(".").replace("None: ", "Without it: ")
        if isinstance(default, StrEnum):
            meaning += f": {', '.join(type(default))}"
        keys.append(Key(name, unit[1] if unit else "", meaning, field.is_required(), default, table_of(description, name)))
    return tuple(keys)


def table_of(description: type[Described], name: str) -> type[Described] | None:
    """The class that describes the table of a key, or each table of its list; None where the key has a plain value."""
    field = description.model_fields.get(name)
    candidates = [field.annotation] if field else []
    while candidates:
        candidate = candidates.pop()
        if isinstance(candidate, type) and not isinstance(candidate, UnionType) and issubclass(candidate, Described):
            return candidate
        candidates += get_args(candidate)
    return None
