"""Flying: the call `fly`; imports nothing that takes time before it is called."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hotlap.api.asked import Asked
from hotlap.first_guess.names import DEFAULT
from hotlap.reference.segmentation_rule import SegmentationRule

if TYPE_CHECKING:
    from hotlap.api.flown import FlightsResult
    from hotlap.api.progress import Progress
    from hotlap.core.parameters import Parameters
    from hotlap.race.race import Race


def fly(
    race: Race | str | Path,
    *,
    parameters: str | Path | Parameters | None = None,
    first_guess: str = DEFAULT,
    flights: int = 100,
    seed: int = 0,
    reference: str | Path | None = None,
    segments: str = SegmentationRule.PAPER,
    controller: str | None = None,
    on: str = "built-in",
    instances: int = 1,
    log: str | Path | None = None,
    hold: str | Sequence[str] | Mapping[str, str] = "",
    cluster: str | None = None,
    progress: Progress | bool | None = None,
) -> FlightsResult:
    """Fly parameters many times, each time with fresh noise: all that `hotlap fly` does.

    Args:
        race: a built-in race (hotlap races) or a TOML file; in Python also a `Race`.
        parameters: a parameters file or a study's folder; in Python also numbers, shape (segments, parameters).
        first_guess: without parameters, what is flown.
        flights: how many, each with noise of its own.
        seed: of the noise.
        reference: read this CSV instead of planning.
        segments: how the reference is cut.
        controller: which one flies; None: the race's.
        on: where to fly.
        instances: simulators that fly side by side, where that is a simulator.
        log: write the first flight as CSV, step by step.
        hold: further conditions to fly them under, such as mass=+-10%, thrust=-20%, delay=+20ms, wind=3; '': none.
        cluster: address of a dask scheduler, or the file it wrote, whose workers fly in simulators; None: this machine.
        progress: receives messages about the progress of the work; True: bars or lines; False: nothing; None: bars in a notebook.

    Returns:
        How each flight ended; a drone that crashes is a result.

    Raises:
        InputError: something that was given is not usable.
        PlanningError: the race has no plan.
    """
    asked = Asked(fly, locals())
    from hotlap.api.flown import carry_out  # noqa: PLC0415  it loads what flies

    return carry_out(asked)
