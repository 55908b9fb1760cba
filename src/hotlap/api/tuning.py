"""Tuning: the call `tune`; imports nothing that takes time before it is called."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal, overload

from hotlap.api.asked import Asked
from hotlap.core.success_rate import RELIABILITY
from hotlap.reference.segmentation_rule import SegmentationRule
from hotlap.tuning.goal_forms import LAP_TIME

if TYPE_CHECKING:
    from hotlap.api.fastest import FastestResult
    from hotlap.api.front import FrontResult
    from hotlap.api.progress import Progress
    from hotlap.api.tuned import TuningResult
    from hotlap.race.race import Race


@overload
def tune(  # pyright: ignore[reportOverlappingOverload]  the narrower one goes first
    race: Race | str | Path,
    *,
    tuner: str = "gate_gp",
    goal: Literal["lap_time"],
    budget: int = 200,
    seed: int = 0,
    out: str | Path | None = None,
    controller: str | None = None,
    confirm: int = 10,
    validation: int = 200,
    batch: int = 8,
    hold: str | Sequence[str] | Mapping[str, str] = "",
    cluster: str | None = None,
    progress: Progress | bool | None = None,
) -> FastestResult | FrontResult: ...


@overload
def tune(
    race: Race | str | Path,
    *,
    tuner: str = "gate_gp",
    goal: str = "completion=1",
    budget: int = 200,
    seed: int = 0,
    out: str | Path | None = None,
    reference: str | Path | None = None,
    segments: str = SegmentationRule.PAPER,
    first_guess: str | None = None,
    controller: str | None = None,
    on: str = "built-in",
    instances: int = 1,
    randomise: float = 0.0,
    samples: int = 0,
    confirm: int = 10,
    validation: int = 200,
    reliability: float = RELIABILITY,
    batch: int = 8,
    selection: int = 2000,
    minutes: float = 0.0,
    hold: str | Sequence[str] | Mapping[str, str] = "",
    cluster: str | None = None,
    progress: Progress | bool | None = None,
) -> TuningResult: ...


def tune(
    race: Race | str | Path,
    *,
    tuner: str = "gate_gp",
    goal: str = "completion=1",
    budget: int = 200,
    seed: int = 0,
    out: str | Path | None = None,
    reference: str | Path | None = None,
    segments: str = SegmentationRule.PAPER,
    first_guess: str | None = None,
    controller: str | None = None,
    on: str = "built-in",
    instances: int = 1,
    randomise: float = 0.0,
    samples: int = 0,
    confirm: int = 10,
    validation: int = 200,
    reliability: float = RELIABILITY,
    batch: int = 8,
    selection: int = 2000,
    minutes: float = 0.0,
    hold: str | Sequence[str] | Mapping[str, str] = "",
    cluster: str | None = None,
    progress: Progress | bool | None = None,
) -> TuningResult | FastestResult | FrontResult:
    """Plan a race, tune its controller, confirm and validate the result, and write a page about it: all that `hotlap tune` does.

    Args:
        race: a built-in race (hotlap races) or a TOML file; in Python also a `Race`.
        tuner: NAME, NAME:PRESET or my_module.MyTuner.
        goal: when to stop.
        budget: flights at most, re-flights included; with minutes, no limit unless it is another number than 200.
        seed: of the search and of the noise.
        out: folder of the study, begun or gone on with; None: runs/RACE-DATE, new.
        reference: read this CSV instead of planning.
        segments: how the reference is cut.
        first_guess: what to begin with; None: learned, on plans with full dynamics that or default, whichever flies better, and in a
            simulator what is tuned in the built-in world first.
        controller: which one flies; None: the race's.
        on: where to fly.
        instances: simulators that fly side by side, where that is a simulator.
        randomise: fly vehicles whose parameters differ from the race's by up to this share.
        samples: flights of each candidate, all to succeed; 0: 1, randomised 4, with minutes 8.
        confirm: re-flights that a candidate must pass (the paper's: 4).
        validation: flights of the result with fresh noise, 0 for none; in a simulator 20, unless it is another number than 200.
        reliability: least share of these to succeed, 0 for any.
        batch: most candidates to fly at once, for tuners that can; with minutes 32, and in a simulator as many as it flies at once,
            unless it is another number than 8.
        selection: flights by which the result is chosen where none was confirmed, 0: the best by its scores; in a simulator 100, unless
            it is another number than 2000.
        minutes: of wall time for search, choice and validation, in which populations are flown; 0: flights are counted, not time.
        hold: further conditions to fly the result under, such as mass=+-10%, thrust=-20%, delay=+20ms, wind=3; '': none.
        cluster: address of a dask scheduler, or the file it wrote, whose workers try plans (goal lap_time)
            or fly in simulators; None: this machine.
        progress: receives messages about the progress of the work; True: bars or lines; False: nothing; None: bars in a notebook.

    Returns:
        How it ended, also where the goal was not confirmed; everything that it found lies in the folder of the study. For the goal lap_time
        a `FastestResult`, the fastest plan that can be flown; with hold a `FrontResult`, the fastest that holds under these conditions, and
        lap time against what it stands.

    Raises:
        InputError: something that was given is not usable.
        PlanningError: the race has no plan.
    """
    asked = Asked(tune, locals())
    if goal.strip() == LAP_TIME:
        from hotlap.api import fastest  # noqa: PLC0415  the search for plans is work of its own

        return fastest.carry_out(asked, tune)
    from hotlap.api.tuned import carry_out  # noqa: PLC0415  it loads what flies

    return carry_out(asked)
