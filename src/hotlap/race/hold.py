"""What a controller is to hold under, in words: `mass=+-10%, thrust=-20%, delay=+20ms, wind=3, gusts=2`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from difflib import get_close_matches
from itertools import product

from hotlap.core.errors import InputError
from hotlap.race.battery import MOST_LOST
from hotlap.race.conditions import SCALED, Change, Condition, Quantity, join_conditions

FORM = "mass=+-10%, thrust=-20%, delay=+20ms, wind=3"
EXAMPLES: Mapping[Quantity, str] = {
    **dict.fromkeys(SCALED, "+10%, -10% or +-10%"),
    Quantity.DELAY: "+20ms or +0.02s",
    Quantity.NOISE: "x2",
    Quantity.WIND: "3 or 3m/s^2",
    Quantity.GUSTS: "2 or 2m/s^2",
    Quantity.SAG: "15%",
}
"""How much of each quantity may be asked for, in the form in which it is written."""
UNITS: Mapping[Quantity, Mapping[str, float]] = {
    **{quantity: {"%": 0.01} for quantity in SCALED},
    Quantity.DELAY: {"ms": 1e-3, "s": 1.0},
    Quantity.NOISE: {"": 1.0},
    Quantity.WIND: dict.fromkeys(("", "m/s^2", "m/s2", "m/s²"), 1.0),
    Quantity.GUSTS: dict.fromkeys(("", "m/s^2", "m/s2", "m/s²"), 1.0),
    Quantity.SAG: {"%": 0.01},
}
LIMITS: Mapping[Quantity, tuple[float, float, str]] = {
    **dict.fromkeys(SCALED, (-0.9, 9.0, "from -90% to +900%")),
    Quantity.DELAY: (-0.25, 0.25, "from -250ms to +250ms"),
    Quantity.NOISE: (0.0, 100.0, "from x0 to x100"),
    Quantity.WIND: (0.0, 100.0, "from 0 to 100 m/s^2"),
    Quantity.GUSTS: (0.0, 100.0, "from 0 to 100 m/s^2"),
    Quantity.SAG: (0.0, MOST_LOST, f"from 0% to {100 * MOST_LOST:g}%"),
}
SIGNS: Mapping[Quantity, tuple[str, ...]] = {
    **dict.fromkeys((*SCALED, Quantity.DELAY), ("+", "-", "+-")),
    **dict.fromkeys((Quantity.WIND, Quantity.GUSTS, Quantity.SAG), ("",)),
    Quantity.NOISE: ("x", ""),
}
MEANT: Mapping[str, Quantity] = {
    "weight": Quantity.MASS,
    "payload": Quantity.MASS,
    "power": Quantity.THRUST,
    "latency": Quantity.DELAY,
    "dead_time": Quantity.DELAY,
    "lag": Quantity.MOTOR,
    "motor_time": Quantity.MOTOR,
    "steady_wind": Quantity.WIND,
    "turbulence": Quantity.GUSTS,
    "battery": Quantity.SAG,
}
"""What other words for a quantity mean."""

_AMOUNT = re.compile(r"(?P<sign>\+-|\+|-|x|)\s*(?P<number>\d+\.?\d*|\.\d+)\s*(?P<unit>.*)")


def parse_hold(text: str) -> tuple[Condition, ...]:
    """Conditions that are asked for: items between commas, `+-` for two of them; with `&` between them items apply together.

    Args:
        text: such as `mass=+-10%, thrust=-20%, delay=+20ms, wind=3 & gusts=2`; without any word: no conditions.

    Returns:
        Each condition once, in the order in which they are written, less before more.

    Raises:
        InputError: an item is not usable; names it, and says what would be right.
    """
    if not text.strip():
        return ()
    found = []
    for item in text.split(","):
        choices = [_changes(part.strip(), item.strip()) for part in item.split("&")]
        found += [_condition(changes, item.strip()) for changes in product(*choices)]
    return join_conditions(found)


def _condition(changes: tuple[Change, ...], item: str) -> Condition:
    """Several changes at once, each of another quantity."""
    quantities = [change.quantity for change in changes]
    for quantity in quantities:
        if quantities.count(quantity) > 1:
            raise _refusal(item, f"changes {quantity} twice at once; a comma makes two conditions of it")
    return Condition(changes, " & ".join(_text(change) for change in changes))


def _changes(part: str, item: str) -> list[Change]:
    """One change, or less and more."""
    name, separator, amount = part.partition("=")
    if not separator:
        raise _refusal(item, f"must be like {FORM}")
    quantity = _quantity(name.strip(), item)
    match = _AMOUNT.fullmatch(amount.strip().replace("±", "+-").replace("+/-", "+-").replace("\N{MINUS SIGN}", "-"))
    example = f"must be like {quantity}={EXAMPLES[quantity]}"
    if match is None:
        raise _refusal(item, example)
    sign, unit = match["sign"], match["unit"].strip()
    if not sign and "+" in SIGNS[quantity]:
        raise _refusal(item, f"less or more? It {example}")
    if sign not in SIGNS[quantity] or unit not in UNITS[quantity]:
        raise _refusal(item, example)
    size = round(float(match["number"]) * UNITS[quantity][unit], 12)
    amounts = {"+-": (-size, size), "-": (-size,)}.get(sign, (size,))
    return [_within(Change(quantity, value), item) for value in amounts]


def _quantity(name: str, item: str) -> Quantity:
    """The quantity of a name."""
    if name in tuple(Quantity):
        return Quantity(name)
    near = get_close_matches(name.lower(), (*Quantity, *MEANT), n=1)
    hint = f" (did you mean {MEANT.get(near[0], near[0])}?)" if near else ""
    raise _refusal(item, f"there is no quantity '{name}'{hint}; available: {', '.join(Quantity)}")


def _within(change: Change, item: str) -> Change:
    """A change that is within the limits of its quantity."""
    low, high, words = LIMITS[change.quantity]
    if not low <= change.amount <= high:
        raise _refusal(item, f"{change.quantity} must be {words}")
    return change


def _text(change: Change) -> str:
    """A change as it may be asked for."""
    match change.quantity:
        case Quantity.DELAY:
            return f"{change.quantity}={1e3 * change.amount:+g}ms"
        case Quantity.NOISE:
            return f"{change.quantity}=x{change.amount:g}"
        case Quantity.WIND | Quantity.GUSTS:
            return f"{change.quantity}={change.amount:g}"
        case Quantity.SAG:
            return f"{change.quantity}={100 * change.amount:g}%"
    return f"{change.quantity}={100 * change.amount:+g}%"


def _refusal(item: str, reason: str) -> InputError:
    return InputError("", "hold", f"'{item}': {reason}")
