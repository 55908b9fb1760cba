"""Recognition: which kind of description a table is, told by its keys."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from typing import Any

from hotlap.core.errors import InputError
from hotlap.files.kinds import Kind
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.race import Race
from hotlap.race.schema import Described
from hotlap.race.track import Track

PARAMETERS = {"names", "segment"}  # keys of a file of tuned parameters
TYPES: Mapping[Kind, type[Described]] = {Kind.RACE: Race, Kind.TRACK: Track, Kind.QUADROTOR: Quadrotor}


def kind_by_keys(table: dict[str, Any]) -> Kind | None:
    """The kind that most keys of a table belong to; None where they belong to every kind or to none."""
    counts = _own_keys(table)
    best = max(counts, key=lambda kind: counts[kind])
    return best if counts[best] else None


def refuse_other_kind(kind: Kind, table: dict[str, Any], label: str) -> None:
    """Refuse a file that describes another kind, before its keys are checked.

    Raises:
        InputError: naming the kind that it describes.
    """
    refuse_parameters(table, label)
    other = kind_by_keys(table)
    if other is not None and not _own_keys(table)[kind]:
        hint = "; a race names its track and its vehicle: hotlap new race NAME" if kind is Kind.RACE else ""
        raise InputError(label, "", f"describes a {other}, not a {kind}{hint}")


def refuse_parameters(table: dict[str, Any], label: str) -> None:
    """Refuse a file of tuned parameters, where a description is read.

    Raises:
        InputError: saying what takes it.
    """
    if set(table) >= PARAMETERS:
        raise InputError(label, "", "holds tuned parameters: give the race that they are for, and this file with parameters=...")


def refuse_description(table: dict[str, Any], label: str) -> None:
    """Refuse a file that describes something, where tuned parameters are read.

    Raises:
        InputError: naming what it describes.
    """
    kind = kind_by_keys(table)
    if kind is not None and not PARAMETERS & set(table):
        raise InputError(label, "", f"describes a {kind}, and holds no parameters: those are in the folder of a study")


def strangers(table: dict[str, Any]) -> str:
    """The first key of a table that nothing has, with the nearest name that something has."""
    available = list(dict.fromkeys(key for description in TYPES.values() for key in description.model_fields))
    unknown = next((key for key in table if key not in available), None)
    if unknown is None:
        return ""
    near = get_close_matches(unknown, available, n=1)
    return f"; there is no key {unknown}{f' (did you mean {near[0]}?)' if near else ''}"


def _own_keys(table: dict[str, Any]) -> dict[Kind, int]:
    """How many keys a table has of each kind, without those that every kind has."""
    shared = set.intersection(*(set(description.model_fields) for description in TYPES.values()))
    return {kind: len((set(table) - shared) & set(description.model_fields)) for kind, description in TYPES.items()}
