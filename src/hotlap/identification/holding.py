"""Holding: what the intervals of an identification leave open, as conditions that a controller can be asked to hold under."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from hotlap.identification.estimates import Estimate
from hotlap.race.conditions import Quantity

SHARES = {  # beginnings of estimates' names
    Quantity.THRUST: ("full thrust per mass",),
    Quantity.MOTOR: ("motor lag",),
    Quantity.RATE_GAIN: ("rate gain",),
    Quantity.DRAG: ("drag", "body drag", "rotor drag"),
}
MOST = 30  # per cent: a number that is open by more is not told


def hold_of(estimates: Sequence[Estimate]) -> str:
    """Words for `--hold`: each quantity off by its interval, rounded up to a whole per cent or millisecond.

    A quantity of several numbers is off by the widest of their intervals, of those that matter: a number that is next to nothing, as drag
    along an axis may be, is left out. What a log does not tell is not among them.
    """
    told = [one for one in estimates if one.told]
    return ", ".join([*_shares(told), *_delay(told)])


def _shares(told: Sequence[Estimate]) -> Iterator[str]:
    for quantity, names in SHARES.items():
        ones = [one for one in told if one.name.startswith(names) and one.value > 0]
        largest = max((one.value for one in ones), default=0.0)
        offs = [max(one.high / one.value - 1, 1 - one.low / one.value) for one in ones if one.value > largest / 4]
        if offs and (most := _whole(100 * max(offs))) <= MOST:
            yield f"{quantity}=+-{most}%"


def _delay(told: Sequence[Estimate]) -> Iterator[str]:
    """There is none below 0."""
    for one in told:
        if one.name == "dead time":
            most = _whole(1e3 * max(one.high - one.value, one.value - one.low))
            yield f"{Quantity.DELAY}=+{'-' if most <= 1e3 * one.value else ''}{most}ms"


def _whole(number: float) -> int:
    """Rounded up, but for errors of arithmetic."""
    return math.ceil(round(number, 6))
