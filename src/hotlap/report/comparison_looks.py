"""Looks of the tuners of a comparison: a colour and dashes for each, in pictures and on the page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

LIGHT = ("#0072b2", "#c44e00", "#00805d", "#b0498f", "#8f6400", "#5f45b8", "#222222")  # each at least 3:1 on white
DARK = ("#5db4f0", "#ff8a3c", "#2fc79a", "#f08cc4", "#e8b23a", "#b6a2ff", "#e6e9ed")  # the same, on the dark paper of a page
DASHES: tuple[tuple[float, ...], ...] = ((), (5, 2), (1.5, 1.5), (7, 2, 1.5, 2), (3, 1, 1, 1, 1, 1))  # in widths of a line


@dataclass(frozen=True)
class Look:
    """How the lines of a tuner look.

    Attributes:
        colour: index in `LIGHT` and `DARK`.
        dashes: index in `DASHES`.
    """

    colour: int
    dashes: int


def looks_of(names: Sequence[str]) -> dict[str, Look]:
    """A look for each tuner, no two the same as long as there are any; presets of one algorithm share a colour as long as there are dashes.

    Args:
        names: `ALGORITHM:PRESET`, no two the same.
    """
    algorithms = list(dict.fromkeys(name.partition(":")[0] for name in names))
    looks: dict[str, Look] = {}
    for name in names:
        place, taken = algorithms.index(name.partition(":")[0]), set(looks.values())
        first = Look(place % len(LIGHT), place % len(DASHES))
        looks[name] = next((look for look in _from(first) if look not in taken), first)
    return looks


def _from(first: Look) -> Iterator[Look]:
    """All looks, those of the same colour first."""
    for colour in range(len(LIGHT)):
        for dashes in range(len(DASHES)):
            yield Look((first.colour + colour) % len(LIGHT), (first.dashes + dashes) % len(DASHES))
