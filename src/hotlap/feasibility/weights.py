"""Weights: the cause that is looked at last, by one parameter at a time that is made much larger or smaller in all segments."""

from __future__ import annotations

import math
from collections.abc import Iterator

from hotlap.core.parameters import Parameters
from hotlap.feasibility.causes import MOSTLY, Case, Cure, FailureCause, Suspicion

FACTORS = (10.0, 4.0)  # by which a parameter is multiplied, and divided


def suspect_weights(case: Case, parameters: Parameters) -> Suspicion:
    """What flights show where they fail, and other weights that may get them past it.

    Args:
        case: flights of which some failed.
        parameters: shape (S, K), that they were flown with.
    """
    signs, place = case.signs, case.where.name or "the end"
    found = f"{math.hypot(signs.along, signs.aside):.2f} m from the reference at {place}"
    shares = {"thrust": signs.saturated, "a body rate": signs.rates_limited}
    limited = " and ".join(f"{name} at its limit" for name, share in shares.items() if share > MOSTLY)
    found += f", {limited or 'with thrust and rates within their limits'}"
    return Suspicion(FailureCause.WEIGHTS, found, tuple(_others(case, parameters)))


def none_helps(gate: str) -> str:
    """What to do where none of these weights helps, in words.

    Args:
        gate: the name of the one at which most flights fail; "" where they pass all.
    """
    sizes = " or ".join(f"{size:g}" for size in FACTORS)
    helped = f"gets many more flights past {gate}" if gate else "makes many more flights meet the goal"
    return f"no single weight, {sizes} times larger or smaller, {helped}: look at the flights"


def _others(case: Case, parameters: Parameters) -> Iterator[Cure]:
    """Parameters of which one is another, as far as its bounds allow."""
    space = case.scenario.space
    for k, name in enumerate(space.names):
        for factor, words in ((by, f"{how} by {size:g}") for size in FACTORS for by, how in ((size, "multiplied"), (1 / size, "divided"))):
            others = parameters.astype(float)
            others[..., k] *= factor
            change = f"{name} {words} in all segments"
            yield Cure(f"tune further, from {change}", change, case.race, case.vehicle_parameters, parameters=space.clip(others))
