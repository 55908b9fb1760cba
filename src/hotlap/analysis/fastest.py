"""Fastest: the plan of shortest lap time that can be flown reliably, and the controller parameters that fly it.

A faster plan leaves less thrust for feedback; wanted is the fastest that is still reliable. Compass search (Kolda, Lewis, Torczon, SIAM
Review 45, 2003): from the best plan so far one step up and down along each axis, in logarithms; the best reliable one is the next centre,
and if there is none, the steps are halved.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hotlap.analysis.plan_trials import Do, PlanSettings, Trial, first_plan_settings, neighbours
from hotlap.race.race import Race
from hotlap.tuning.loop import TuningSettings

RELIABLE = 0.95  # least validated rate
HALVINGS = 3  # of the steps, before it ends
GAIN = 1e-3  # least share by which a lap must be shorter to go on from there


def is_reliable(result: dict[str, Any]) -> bool:
    """Whether enough flights of a plan have passed every gate."""
    return result["lap"] is not None and result["rate"] >= RELIABLE


def best_of(results: Sequence[tuple[PlanSettings, dict[str, Any]]]) -> tuple[PlanSettings, dict[str, Any]] | None:
    """The reliable plan of shortest lap time; the first among equals."""
    good = [pair for pair in results if is_reliable(pair[1])]
    return min(good, key=lambda pair: pair[1]["lap"]) if good else None


def fastest(
    race: Race, tuner: str, settings: TuningSettings, do: Do, judge: Do, most_rounds: int = 40
) -> tuple[PlanSettings, dict[str, Any]] | None:
    """The search: the best plan settings, with what was found by them; None where no plan can be flown reliably.

    Args:
        race: its planning is where the search begins; where that cannot be flown, slower plans come first.
        tuner: algorithm with preset.
        settings: of each tuning.
        do: tunes plans, by keys, and gives what `try_plan` finds of each.
        judge: flies plans again, by keys, and gives what `judge_plan` finds of each. The fastest of many is partly chosen by luck, so the
            winner is the fastest that is reliable in these flights too.
        most_rounds: of trials, before it ends.
    """
    centre, shrunk, best, nearest = first_plan_settings(race), 1.0, None, (-1.0, -1.0)
    ranked: list[tuple[PlanSettings, dict[str, Any]]] = []
    trials, tried = {centre.key: Trial(race, centre, tuner, settings)}, {centre.key}
    for _ in range(most_rounds):
        done = do(trials)
        results = [(trial.plan_settings, done[key]) for key, trial in trials.items()]
        found, moved = best_of(results), False
        ranked += [pair for pair in results if is_reliable(pair[1])]
        if found and (best is None or found[1]["lap"] < (1 - GAIN) * best[1]["lap"]):
            best, centre, moved = found, found[0], True
        elif best is None:
            for plan_settings, result in results:
                near = result["rate"], result["planned"] or 0.0  # where none is reliable, the most successful, then the slowest
                if near > nearest:
                    nearest, centre, moved = near, plan_settings, True
        if not moved:
            shrunk /= 2
        if shrunk < 2.0**-HALVINGS:
            break
        begin = None if best is None else tuple(np.exp(np.log(best[1]["parameters"]).mean(axis=0)).tolist())
        around = [plan_settings for plan_settings in neighbours(race, centre, shrunk) if plan_settings.key not in tried]
        trials = {
            f"{plan_settings.key}, after {centre.key}": Trial(race, plan_settings, tuner, settings, begin) for plan_settings in around
        }
        tried |= {plan_settings.key for plan_settings in around}
    return _first_reliable(race, tuner, settings, sorted(ranked, key=lambda pair: pair[1]["lap"]), judge)


def _first_reliable(
    race: Race, tuner: str, settings: TuningSettings, ranked: Sequence[tuple[PlanSettings, dict[str, Any]]], judge: Do
) -> tuple[PlanSettings, dict[str, Any]] | None:
    """The first that is reliable in other flights too, with what was found by these."""
    for plan_settings, result in ranked:
        key = f"{plan_settings.key}, once more"
        again = judge({key: Trial(race, plan_settings, tuner, settings, parameters=tuple(map(tuple, result["parameters"])))})[key]
        if is_reliable(again):
            return plan_settings, {**result, **again}
    return None
