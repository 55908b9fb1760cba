"""Explanation: what a margin means, and what would leave enough thrust, in words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from hotlap.feasibility.demands import HELD, running_mean
from hotlap.feasibility.finding import Finding, note_if
from hotlap.feasibility.margins import ENOUGH, Margin
from hotlap.race.race import Race
from hotlap.reference.reference import Reference

ALL = 0.999  # of the rates
HOVERING = 1.15  # thrust-to-weight below which a plan makes no sense


@dataclass(frozen=True)
class ThrustAdvice:
    """What would leave enough thrust.

    Attributes:
        advice: what to do: "set planning.thrust_share = 0.72, estimated".
        change: what that changes, in words that do not recommend it: "planning.thrust_share = 0.72".
    """

    advice: str
    change: str


def share_with_margin(race: Race, found: Margin) -> float | None:
    """About the `planning.thrust_share` whose plan leaves enough; None where none does, or the race does not plan by a share.

    Args:
        race: whose plan it is.
        found: its margin.
    """
    if race.planning.quadrotor is not None:
        return None
    most = race.control_model.max_acceleration
    share = math.floor(100 * found.shrink * race.planning_model.max_acceleration / most) / 100
    return share if share * most > HOVERING * race.control_model.gravity else None


def explain(race: Race, reference: Reference, found: Margin, *, planned: bool = True) -> str:
    """What a margin means and what would help, in words; "" where enough is left.

    Args:
        race: that is flown.
        reference: whose margin it is.
        found: the margin.
        planned: whether the reference was planned; a plan for less thrust can take its place.
    """
    return "" if found.enough else f"{verdict_on(found)}; {help_with(race, reference, found, planned=planned).advice}"


def verdict_on(found: Margin) -> str:
    """What a margin means that is not enough, in words.

    Args:
        found: the margin.
    """
    verdict = "no weights will help" if found.lacking else "hardly any is left to correct with"
    if not found.lacking and found.thrust >= ENOUGH:
        verdict = "less what the rotors need to turn the drone, hardly any is left to correct with"
    verdict = "for a while less than that is there" if found.thrust < 1 and found.passing else verdict
    return f"{found.figure} of the thrust that is needed {found.place}: {verdict}"


def help_with(race: Race, reference: Reference, found: Margin, *, planned: bool = True) -> ThrustAdvice:
    """What would leave enough thrust; arguments as for `explain`."""
    capped = planned and race.planning_model.max_acceleration > 0.94 * race.controller.thrust[1]  # a higher limit makes a bolder plan
    if found.limit is not None and not capped:
        change = f"controller.thrust = [{race.controller.thrust[0]:g}, {math.ceil(10 * found.limit) / 10:g}]"
        return ThrustAdvice(f"set {change}, which the rotors have", change)
    stronger = ThrustAdvice("take stronger rotors: no slower plan leaves enough thrust", "more thrust")
    if planned and race.planning.quadrotor is None:
        share = share_with_margin(race, found)
        change = f"planning.thrust_share = {share or 0:g}"
        return stronger if share is None else ThrustAdvice(f"set {change}, estimated", change)
    most = found.shrink * running_mean(reference.thrust[: reference.planned_rows], round(HELD / reference.period)).max()
    if most < HOVERING * race.control_model.gravity:
        return stronger
    change = f"{'a plan' if planned else 'a reference'} that takes at most {most:.1f} m/s^2"
    return ThrustAdvice(f"fly {change}", change)


def describe_margins(race: Race, reference: Reference, found: Sequence[Margin], *, planned: bool = True) -> Iterator[Finding]:
    """What is left of thrust and rates.

    Args:
        race: that is flown.
        reference: planned or read.
        found: from `margins`.
        planned: whether it was planned.
    """
    for one in found:
        told = explain(race, reference, one, planned=planned).removeprefix(f"{one.figure} ")
        remark = told or f"of the thrust that is needed, {one.place}"
        label, figures = f"- {one.condition.name}" if one.condition.changes else "thrust left", {"thrust_margin": one.thrust}
        yield Finding(label, one.figure, remark, note_if(not one.enough), figures)
    rates, tight = found[0].rates, found[0].rates < ALL
    remark = f"of the body rates that are needed{'; raise controller.rates' * tight}"
    yield Finding("rates left", f"{rates:.2f}", remark, note_if(tight), {"rates_margin": rates})
