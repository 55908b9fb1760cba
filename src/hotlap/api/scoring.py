"""Scoring: the call `score`; imports nothing that takes time before it is called."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hotlap.api.asked import Asked
from hotlap.first_guess.names import DEFAULT
from hotlap.reference.segmentation_rule import SegmentationRule

if TYPE_CHECKING:
    from hotlap.api.progress import Progress
    from hotlap.api.scored import ScoredFlight
    from hotlap.core.parameters import Parameters
    from hotlap.race.race import Race


def score(
    log: str | Path,
    *,
    race: Race | str | Path,
    map: str | Path | Mapping[str, Any] | None = None,  # noqa: A002  the option's name
    window: tuple[float | None, float | None] | None = None,
    align: bool = False,
    start: float | None = None,
    parameters: str | Path | Parameters | None = None,
    first_guess: str = DEFAULT,
    flights: int = 20,
    seed: int = 0,
    reference: str | Path | None = None,
    segments: str = SegmentationRule.PAPER,
    controller: str | None = None,
    out: str | Path | None = None,
    progress: Progress | bool | None = None,
) -> ScoredFlight:
    """Judge a flight that really happened, beside simulated ones: all that `hotlap score` does.

    Args:
        log: of a flight: PX4 ULog, Betaflight blackbox, ArduPilot dataflash, MCAP, a ROS bag, hotlap's own CSV or another table.
        race: a built-in race (hotlap races) or a TOML file; in Python also a `Race`.
        map: TOML file that says which columns of a table, or which topics, are which signal; in Python also a dict.
        window: seconds of the log's clock from which on and up to which it counts, (from, to); None: all of it.
        align: lay the flight over the reference, by a shift and a turn about z, where the frame of the log is not that of the race.
        start: seconds of the log's clock at which the race begins; None: found.
        parameters: of the simulated flights: a parameters file or a study's folder; in Python also numbers, shape (segments, parameters).
        first_guess: without parameters, what is flown in the simulation.
        flights: how many simulated ones.
        seed: of their noise.
        reference: read this CSV instead of planning.
        segments: how the reference is cut.
        controller: which one flies in the simulation; None: the race's.
        out: write a page about it, FILE.html.
        progress: receives messages about the progress of the work; True: bars or lines; False: nothing; None: bars in a notebook.

    Returns:
        Completion, lap, errors and effort of both; a drone that crashed is a result.

    Raises:
        InputError: something that was given is not usable, or the log does not say where the drone was.
        PlanningError: the race has no plan.
    """
    asked = Asked(score, locals())
    from hotlap.api.scored import carry_out  # noqa: PLC0415  it loads what flies

    return carry_out(asked)
