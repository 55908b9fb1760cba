"""Checking: the call `check`; imports nothing that takes time before it is called."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from hotlap.api.asked import Asked
from hotlap.reference.segmentation_rule import SegmentationRule

if TYPE_CHECKING:
    from hotlap.api.checked import CheckedFile
    from hotlap.api.progress import Progress
    from hotlap.race.quadrotor import Quadrotor
    from hotlap.race.race import Race
    from hotlap.race.track import Track


def check(
    file: Race | Track | Quadrotor | str | Path,
    *,
    reference: str | Path | None = None,
    segments: str = SegmentationRule.PAPER,
    controller: str | None = None,
    flights: int = 50,
    progress: Progress | bool | None = None,
) -> CheckedFile:
    """Say what a track, a quadrotor or a race means; a race is planned and flown: all that `hotlap check` does.

    Args:
        file: a TOML file, or the name of a built-in race, track or quadrotor; in Python also what was read from one.
        reference: of a race: read this CSV instead of planning.
        segments: of a race: how the reference is cut.
        controller: of a race: which one flies; None: the race's.
        flights: of a race, with the default weights, and as many with the first guess; 0: none.
        progress: receives messages about the progress of the work; True: bars or lines; False: nothing; None: bars in a notebook.

    Returns:
        The findings; a race without a plan is one, not an error.

    Raises:
        InputError: something that was given is not usable.
    """
    asked = Asked(check, locals())
    from hotlap.api.checked import carry_out  # noqa: PLC0415  it loads what plans and flies

    return carry_out(asked)
