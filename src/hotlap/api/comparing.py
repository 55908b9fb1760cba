"""Comparing: the call `compare`; imports nothing that takes time before it is called."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hotlap.api.asked import Asked
from hotlap.first_guess.names import DEFAULT
from hotlap.reference.segmentation_rule import SegmentationRule

if TYPE_CHECKING:
    from hotlap.api.compared import ComparisonResult
    from hotlap.api.progress import Progress
    from hotlap.race.race import Race


def compare(
    races: Sequence[Race | str | Path] | Race | str | Path,
    *,
    out: str | Path,
    tuners: str | Sequence[str] = "gate_gp,metropolis_hastings,cma_es,random_search",
    seeds: int = 10,
    budget: str | int = "200",
    goal: str = "completion=1",
    confirm: int = 4,
    randomise: float = 0.0,
    samples: int = 0,
    validation: int = 50,
    first_guess: str = DEFAULT,
    jobs: int = 0,
    reference: str | Path | None = None,
    segments: str = SegmentationRule.PAPER,
    controller: str | None = None,
    on: str = "built-in",
    instances: int = 1,
    hold: str | Sequence[str] | Mapping[str, str] = "",
    cluster: str | None = None,
    progress: Progress | bool | None = None,
) -> ComparisonResult:
    """Run tuners on races with the same first guess, budget, seeds and noise: all that `hotlap compare` does.

    It flies in several processes, so a script calls it below `if __name__ == "__main__":`, or with `jobs=1`.

    Args:
        races: built-in races (hotlap races), patterns of them ('circle-*'), sets (all, default, airsim, real) or TOML files; in Python
            also one alone, and each of them a `Race`.
        out: folder of the comparison, begun or gone on with.
        tuners: NAME, NAME:PRESET or my_module.MyTuner of each; in Python also a list.
        seeds: runs of each tuner on each race.
        budget: flights of a run, re-flights included: 200,cma_es=1000; in Python also a number.
        goal: when a run stops.
        confirm: re-flights that a candidate must pass.
        randomise: fly vehicles whose parameters differ from the race's by up to this share.
        samples: flights of each candidate, all to succeed; 0: 1, randomised 4.
        validation: flights of each result with fresh noise.
        first_guess: where all begin.
        jobs: processes; 0: one a processor.
        reference: read this CSV instead of planning; of one race.
        segments: how the reference is cut.
        controller: which one flies; None: the race's.
        on: where to fly.
        instances: simulators that fly side by side, where that is a simulator.
        hold: conditions to fly each result under, such as mass=+-10%, thrust=-20%, delay=+20ms, wind=3; '': none.
        cluster: address of a dask scheduler, or the file it wrote, whose workers do the runs; None: this machine.
        progress: receives messages about the progress of the work; True: bars or lines; False: nothing; None: bars in a notebook.

    Returns:
        Every run, and a row for each tuner on each race.

    Raises:
        InputError: something that was given is not usable.
        PlanningError: a race has no plan.
    """
    asked = Asked(compare, locals())
    from hotlap.api.compared import carry_out  # noqa: PLC0415  it loads what flies

    return carry_out(asked)
