"""Held: what was asked of a controller with `hold`, and in words and figures how it did."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hotlap.analysis.robustness import HELD, Robustness
from hotlap.api.wording import percent
from hotlap.core.counts import count
from hotlap.core.errors import InputError
from hotlap.feasibility.margins import Margin
from hotlap.race.conditions import Condition, check_conditions
from hotlap.race.hold import parse_hold
from hotlap.race.race import Race
from hotlap.worlds.world import World


def read_hold(text: str, race: Race, world: World) -> tuple[Condition, ...]:
    """The conditions that are asked for, which race and world can fly.

    Raises:
        InputError: an item is not usable, or the world flies the vehicle that it has.
    """
    conditions = parse_hold(text)
    if conditions and not world.takes_vehicle_parameters:
        raise InputError("", "hold", f"{world.name} flies the vehicle that it has")
    check_conditions(conditions, race)
    return conditions


def all_held(robustness: Sequence[Robustness]) -> bool | None:
    """Whether parameters hold under every condition that was asked for; None where nobody asked."""
    asked = [one.holds for one in robustness if one.asked]
    return all(asked) if asked else None


def say_held(robustness: Sequence[Robustness]) -> str:
    """In a line, whether parameters hold under what was asked for; "" where nobody asked."""
    asked = [one for one in robustness if one.asked]
    lost = [one.change for one in asked if not one.holds]
    if not asked:
        return ""
    if lost:
        return f"{len(lost)} of {count(len(asked), 'condition')} NOT held in {percent(HELD)} of the flights: {', '.join(lost)}"
    return f"{count(len(asked), 'condition')} asked for, {'all ' * (len(asked) > 1)}held in at least {percent(HELD)} of the flights"


def dump_margin(margin: Margin | None) -> Mapping[str, Any] | None:
    """As plain JSON."""
    return None if margin is None else margin.dump()


def dump_robustness(robustness: Robustness) -> Mapping[str, Any]:
    """As plain JSON."""
    return robustness.dump()
