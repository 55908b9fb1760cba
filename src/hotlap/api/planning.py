"""Planning: the call `plan`; imports nothing that takes time before it is called."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from hotlap.api.asked import Asked
from hotlap.reference.segmentation_rule import SegmentationRule

if TYPE_CHECKING:
    from hotlap.api.planned import PlannedReference
    from hotlap.api.progress import Progress
    from hotlap.race.race import Race


def plan(
    race: Race | str | Path,
    *,
    out: str | Path | None = None,
    picture: str | Path | None = None,
    reference: str | Path | None = None,
    segments: str = SegmentationRule.PAPER,
    cache: bool = True,
    progress: Progress | bool | None = None,
) -> PlannedReference:
    """Plan the fastest flight through a race's gates, and cut it into segments: all that `hotlap plan` does.

    Args:
        race: a built-in race (hotlap races) or a TOML file; in Python also a `Race`.
        out: write the reference as CSV.
        picture: draw it: .png, .svg or .pdf.
        reference: read this CSV instead of planning.
        segments: how the reference is cut.
        cache: take the plan from the user's cache, and leave it there; False: plan anew, and keep nothing in the cache of plans.
        progress: receives messages about the progress of the work; True: bars or lines; False: nothing; None: bars in a notebook.

    Returns:
        The reference with its segments.

    Raises:
        InputError: something that was given is not usable.
        PlanningError: the race has no plan.
    """
    asked = Asked(plan, locals())
    from hotlap.api.planned import carry_out  # noqa: PLC0415  it loads what plans

    return carry_out(asked)
