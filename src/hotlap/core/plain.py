"""Plain JSON read back: every number is of the kind that a record of ours says, whatever somebody has written there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from hotlap.core.errors import InputError

KINDS: Mapping[str, tuple[type, ...]] = {"int": (int,), "float": (int, float), "bool": (bool,)}


def typed(record: type, plain: Mapping[str, Any]) -> dict[str, Any]:
    """What a dataclass is made of, as it stands in JSON, once it is looked at.

    Args:
        record: the dataclass.
        plain: values by the names of its fields; those that are neither numbers nor truths are left to the caller.

    Returns:
        The same values.

    Raises:
        InputError: a number is none.
    """
    kinds = {field.name: str(field.type) for field in fields(record)}
    return {name: value_of(kinds.get(name, ""), name, value) for name, value in plain.items()}


def value_of(kind: str, name: str, value: Any) -> Any:
    """A value that is of a kind: `int`, `float` or `bool`; any other kind is not looked at.

    Raises:
        InputError: it is not.
    """
    wanted = KINDS.get(kind)
    if wanted is None or (isinstance(value, wanted) and (kind == "bool" or not isinstance(value, bool))):
        return value
    raise InputError("", name, f"must be of the kind {kind}, not {type(value).__name__}")
