"""Given: arguments of a call, of the types that its signature names; what is not is said in Python's words before anything begins."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from numbers import Integral, Real
from pathlib import PurePath
from typing import Any

from hotlap.core.errors import InputError

WORDS = {
    "int": "a whole number",
    "float": "a number",
    "str": "text",
    "Path": "a path",
    "None": "None",
    "Race": "a Race",
    "Track": "a Track",
    "Quadrotor": "a Quadrotor",
    "Sequence": "a list",
    "Mapping": "a dict",
    "Parameters": "an array",
}
"""What the types are called in messages; an annotation with any other is not checked."""
KINDS = {"Sequence": ("list", "tuple"), "Mapping": ("dict",), "Parameters": ("ndarray", "list", "tuple"), "None": ("NoneType",)}
"""Names of the classes that count as a type, where these are not its own."""


def as_annotated(call: Callable[..., Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of a call, numbers of numpy as those of Python, conditions as one text.

    Args:
        call: a function whose annotations are text.
        given: its arguments by name; others are taken as they are.

    Raises:
        InputError: with the name of an argument that is of another type.
    """
    parameters = inspect.signature(call).parameters
    found = {name: _one(name, value, parameters[name].annotation) if name in parameters else value for name, value in given.items()}
    if "hold" in found:
        found["hold"] = hold_text(found["hold"])
    return found


def hold_text(hold: Any) -> str:
    """Conditions as one text, from a text, a list of them, or a dict of amounts by quantity."""
    if isinstance(hold, Mapping):
        return ", ".join(f"{quantity}={amount}" for quantity, amount in hold.items())
    return hold if isinstance(hold, str) else ", ".join(map(str, hold))


def _one(name: str, value: Any, annotation: Any) -> Any:
    """An argument, checked."""
    parts = _parts(annotation) if isinstance(annotation, str) else []
    if not parts or any(part not in WORDS for part in parts):
        return value
    classes = {each.__name__ for each in type(value).__mro__}
    if isinstance(value, bool):
        classes -= {"int", "object"}
    if any(classes & set(KINDS.get(part, (part,))) for part in parts):
        return value
    if "str" in parts and isinstance(value, PurePath):
        return str(value)
    if "int" in parts and isinstance(value, Integral) and not isinstance(value, bool):
        return int(value)
    if "float" in parts and isinstance(value, Real) and not isinstance(value, bool):
        return float(value)
    *others, last = [WORDS[part] for part in parts]
    wanted = f"{', '.join(others)} or {last}" if others else last
    raise InputError("", name, f"must be {wanted}, not {_shown(value)}")


def _parts(annotation: str) -> list[str]:
    """The types of an annotation, without what stands in brackets."""
    outside, depth = "", 0
    for character in annotation:
        depth += (character == "[") - (character == "]")
        outside += character if not depth and character != "]" else ""
    return [part.strip().rpartition(".")[2] for part in outside.split("|")]


def _shown(value: Any) -> str:
    """A value that is not usable: what it is, and its type where that does not show."""
    text = " ".join(repr(value).split())
    return text if isinstance(value, str | int | float | None) and len(text) <= 40 else f"a {type(value).__name__}"
