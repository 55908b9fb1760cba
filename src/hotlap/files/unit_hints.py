"""Unit hints: a number that is a thousand or 57 times too large was meant in another unit; what it is in the unit of its key."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hotlap.core.errors import InputError
from hotlap.race.schema import Described

DIGITS = 4  # significant ones of a suggestion
FASTEST = 100.0  # rad/s: no drone is asked to turn faster
RATES = frozenset({"rate_limit", "rates"})  # keys of body rates that nothing bounds
UNITS: Mapping[str, tuple[str, float]] = {  # of a key: its name, and what the unit that is taken for it has to be multiplied by
    "s": ("in seconds", 1e-3),  # milliseconds
    "m": ("in metres", 1e-3),  # millimetres
    "kg": ("in kilograms", 1e-3),  # grams
    "rad": ("in radians", math.pi / 180),  # degrees
    "rad/s": ("in radians a second", math.pi / 180),  # degrees a second
    "-": ("as a fraction", 1e-2),  # per cent
}


def in_unit(unit: str, value: Any, fits: Callable[[float], bool]) -> tuple[str, str]:
    """The name of a key's unit, and a value in it; both "" where that would not do either.

    Args:
        unit: of the key.
        value: a number, or a list of numbers, as it was given.
        fits: whether a number may stand there.
    """
    name, factor = UNITS.get(unit, ("", 1.0))
    numbers = value if isinstance(value, list | tuple) else [value]
    plain = all(isinstance(number, int | float) and not isinstance(number, bool) for number in numbers)
    if not name or not plain or not all(fits(factor * number) for number in numbers):
        return "", ""
    words = ", ".join(f"{factor * number:.{DIGITS}g}" for number in numbers)
    return name, f"[{words}]" if isinstance(value, list | tuple) else words


def refuse_degrees(description: Described, source: str, prefix: str) -> None:
    """Refuse body rates that no drone has: they are in degrees a second.

    Raises:
        InputError: naming the key and its value in radians a second.
    """
    for name in type(description).model_fields:
        value, key = getattr(description, name), f"{prefix}.{name}" if prefix else name
        if isinstance(value, Described):
            refuse_degrees(value, source, key)
        elif name in RATES and isinstance(value, Sequence) and max(value) > FASTEST:
            unit, meant = in_unit("rad/s", value, lambda rate: rate <= FASTEST)
            hint = f" ({unit}: {meant}?)" if meant else ""
            raise InputError(source, key, f"{max(value):g} rad/s is no body rate of a drone{hint}")
