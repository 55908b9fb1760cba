"""Error messages: faults in a file, found by pydantic, as one line with key and reason."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, TypeVar

import numpy as np
from pydantic import ValidationError

from hotlap.core.errors import InputError
from hotlap.files.documented_keys import Key, documented_keys, table_of
from hotlap.files.toml_writer import write_value
from hotlap.files.unit_hints import UNITS, in_unit, refuse_degrees
from hotlap.race.schema import Described

Location = tuple[int | str, ...]

D = TypeVar("D", bound=Described)

MOST_FAULTS = 200  # that are looked at
UNIT_NAMES = tuple(name for name, _ in UNITS.values())
_KEYED = re.compile(r"(?P<key>[A-Za-z_]\w*(?:\[\d+\])?(?:\.\w+)*): (?P<reason>.*)", re.DOTALL)

_REASONS: dict[str, Callable[[dict[str, Any]], str]] = {
    "greater_than": lambda context: f"must be greater than {context['gt']:g}",
    "greater_than_equal": lambda context: f"must be at least {context['ge']:g}",
    "less_than": lambda context: f"must be less than {context['lt']:g}",
    "less_than_equal": lambda context: f"must be at most {context['le']:g}",
    "finite_number": lambda _: "must be a finite number",
    "float_type": lambda _: "must be a number",
    "int_type": lambda _: "must be a whole number",
    "int_from_float": lambda _: "must be a whole number",
    "bool_type": lambda _: "must be true or false",
    "string_type": lambda _: "must be text in quotation marks",
    "string_too_short": lambda _: "must not be empty",
    "model_type": lambda _: "must be a table",
    "dict_type": lambda _: "must be a table",
    "enum": lambda context: f"must be {context['expected'].replace(chr(39), chr(34))}",
}


def check(description: type[D], table: Mapping[str, Any], source: str, prefix: str = "") -> D:
    """A description from a file's table.

    Args:
        description: what the table should be.
        table: what was read; descriptions may stand in it.
        source: the file.
        prefix: dotted key of the table within the file, or "" for the whole file.

    Raises:
        InputError: the first fault of the table, with its key, and how many more there are.
    """
    try:  # as JSON: strict about types, yet lists may stand for tuples and names for enumerations
        with np.errstate(all="ignore"):  # numbers out of all bounds are refused, and need no warning beside that
            checked = description.model_validate_json(json.dumps(table, default=_encode), strict=True)
    except ValidationError as error:
        raise _refuse(error, description, source, prefix) from None
    refuse_degrees(checked, source, prefix)
    return checked


def unknown_key(name: str, available: Sequence[str], hint: str = "") -> str:
    """The message for an unknown key, with the nearest known one, or another hint in its place."""
    near = get_close_matches(name, available, n=1)
    hint = hint or (f" (did you mean {near[0]}?)" if near else "")
    return f"there is no such key{hint}; available: {', '.join(available)}"


def homes_of(description: type[Described], name: str) -> str:
    """The tables within a description that have a key, "vehicle or model"; "" where none has it."""
    tables = ((key.name, key.table) for key in documented_keys(description))
    return " or ".join(home for home, table in tables if table is not None and name in table.model_fields)


def show(value: Any) -> str:
    """A value as it is written in the file, shortened."""
    try:
        text = write_value(value)
    except (TypeError, ValueError, OverflowError):
        text = str(value)
    return text if len(text) <= 40 else text[:37] + "..."


def _encode(value: Any) -> Any:
    """Values that JSON does not have: descriptions as tables, TOML's dates as text."""
    return value.model_dump(mode="json", exclude_unset=True) if isinstance(value, Described) else str(value)


def _refuse(error: ValidationError, description: type[Described], source: str, prefix: str) -> InputError:
    """The error for the first fault, with the number of further faults."""
    faults: list[tuple[str, str]] = []
    found = sorted(
        error.errors(include_url=False), key=lambda fault: fault["type"] != "extra_forbidden"
    )  # a misspelt key explains a missing one
    least, found = "at least " if len(found) > MOST_FAULTS else "", found[:MOST_FAULTS]
    for fault in found:
        key, reason = _word(dict(fault), [other["loc"] for other in found], description)
        if key not in {known for known, _ in faults} and not _follows(fault["loc"], fault["type"], found):
            faults.append((key, reason))
    key, reason = faults[0]
    more = len(faults) - 1
    also = f" (and {least}{more} more fault{'s' if more > 1 else ''}: {', '.join(key for key, _ in faults[1:4])})" if more else ""
    return InputError(source, ".".join(part for part in (prefix, key) if part), reason + also)


def _write_location(location: Location) -> str:
    """`("gates", 3, "position")` as `gates[3].position`."""
    text = ""
    for part in location:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def _word(fault: dict[str, Any], locations: list[Location], description: type[Described]) -> tuple[str, str]:
    """Key and reason of one fault."""
    kind, location, value, context = fault["type"], fault["loc"], fault["input"], fault.get("ctx", {})
    if kind == "extra_forbidden":
        owner = _owner(description, location)
        available = [key.name for key in documented_keys(owner)] + ["base"] * ("name" in owner.model_fields)
        homes = homes_of(description, str(location[-1])) if len(location) == 1 else ""
        hint = f" (it belongs into {homes})" if homes else ""
        return _write_location(location), unknown_key(str(location[-1]), available, hint)
    if kind == "missing":
        return _missing(location, value, locations, description)
    if kind == "too_short":
        return _write_location(location), "must have at least one entry"
    if kind == "too_long":
        reason = f"must have {context['max_length']} values, not {context['actual_length']}"
        return _write_location(location), reason + _meaning_of(description, location)
    if kind == "tuple_type":
        return _write_location(location), f"must be a list in brackets, not {show(value)}{_meaning_of(description, location)}"
    if kind == "value_error":
        key, reason = _keyed(location, str(context["error"]))
        meant = _in_its_unit(description, location, value)[1] if reason.endswith(UNIT_NAMES) else ""
        return key, f"{reason} (did you mean {meant}?)" if meant else reason
    worded = _REASONS.get(kind)
    reason = worded(context) if worded else fault["msg"][:1].lower() + fault["msg"][1:]
    name, meant = _in_its_unit(description, location, value, most) if (most := context.get("le", context.get("lt"))) else ("", "")
    return _write_location(location), f"{reason}, not {show(value)}{f' ({name}: {meant}?)' if meant else ''}"


def _missing(location: Location, value: Any, locations: list[Location], description: type[Described]) -> tuple[str, str]:
    """A required key that is not there, or a list that is too short."""
    if isinstance(location[-1], int):
        wanted = 1 + max(other[-1] for other in locations if other[:-1] == location[:-1] and isinstance(other[-1], int))
        return _write_location(location[:-1]), f"must have {wanted} values, not {len(value)}{_meaning_of(description, location[:-1])}"
    return _write_location(location), f"is missing; it is needed{_meaning_of(description, location)}"


def _meaning_of(description: type[Described], location: Location) -> str:
    """What the values of a key mean, with their unit: to be written behind a reason."""
    key = _key_of(description, location)
    meaning = "" if key is None else " ".join(part for part in (f"[{key.unit}]" if key.unit else "", key.meaning) if part)
    return f": {meaning}" if meaning else ""


def _in_its_unit(description: type[Described], location: Location, value: Any, most: float = math.inf) -> tuple[str, str]:
    """The unit of a key, and a value in it that was probably given in another one, of at most so much; as `in_unit`."""
    key = _key_of(description, location)
    return ("", "") if key is None else in_unit(key.unit, value, lambda number: 0 <= number <= most)


def _key_of(description: type[Described], location: Location) -> Key | None:
    """What is documented of the key at a location."""
    names = [part for part in location if isinstance(part, str)]
    return next((key for key in documented_keys(_owner(description, (*names,))) if names and key.name == names[-1]), None)


def _keyed(location: Location, message: str) -> tuple[str, str]:
    """A validator's message; one about a whole table begins with the key that it is about."""
    match = _KEYED.fullmatch(message)
    if match is None:
        return _write_location(location), message
    return ".".join(part for part in (_write_location(location), match["key"]) if part), match["reason"]


def _owner(description: type[Described], location: Location) -> type[Described]:
    """The description of the table that the last part of a location belongs to."""
    for part in location[:-1]:
        if isinstance(part, str):
            description = table_of(description, part) or description
    return description


def _follows(location: Location, kind: str, found: Sequence[Any]) -> bool:
    """Whether a fault is only the consequence of another: a default not worked out, a list short because its items are faulty."""
    if kind == "default_factory_not_called":
        return True
    return kind == "too_short" and any(other["loc"][: len(location)] == location != other["loc"] for other in found)
