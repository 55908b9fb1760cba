"""Preparation: what stands between a race and its first flight: a reference, its segments, and parameters that fit them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.files.descriptions import load_race
from hotlap.files.parameters_file import SavedParameters
from hotlap.planning import plan
from hotlap.race.race import Race
from hotlap.reference.scenario import Scenario
from hotlap.reference.segmentation import SegmentationRule, Segments, segment
from hotlap.reference_files.csv import read_reference

MOVED = 0.1  # s by which starts of segments may differ and be called the same


def prepare(
    race: Race | str | Path, reference: str | Path | None = None, *, cache: bool = True, segments: SegmentationRule = SegmentationRule.PAPER
) -> Scenario:
    """Make a race ready to fly: plan it, or read its reference, and cut that into segments.

    Args:
        race: a race, the name of a built-in one, or a file.
        reference: a CSV to read instead of planning.
        cache: take the plan from the user's cache if it is there, and leave it there.
        segments: how it is cut.

    Raises:
        InputError: a file is not usable.
        PlanningError: there is no plan, or none was found.
    """
    race = race if isinstance(race, Race) else load_race(race)
    if reference is None:
        planned = plan(race, cache=cache)
        return Scenario(race, planned, segment(planned, segments))
    read = read_reference(Path(reference), race)
    return Scenario(race, read.reference, segment(read.reference, segments), read.notes)


def parameters_for(scenario: Scenario, saved: SavedParameters, source: str) -> NDArray[np.float64]:
    """Saved parameters in the order of the scenario's space, shape (S, K).

    Args:
        scenario: what they are wanted for; its number of segments, names and bounds count, not the name of its race.
        saved: as read from a file.
        source: the file, for messages.

    Raises:
        InputError: when they do not fit.
    """
    space, segments = scenario.space, scenario.segments
    if sorted(saved.names) != sorted(space.names):
        raise InputError(source, "names", f"are {', '.join(saved.names)}; the controller takes {', '.join(space.names)}")
    if len(saved.segments) != len(segments):
        reason = f"there are {len(saved.segments)}, tuned for {saved.race}; {scenario.race.name} has {len(segments)}"
        raise InputError(source, "segment", f"{reason}, and parameters belong to the segments of one reference, cut by one rule")
    values = saved.values[:, [saved.names.index(name) for name in space.names]]
    for i, j in np.argwhere((values < space.low) | (values > space.high)).tolist():
        bounds = f"[{space.low[j]:g}, {space.high[j]:g}], which controller.low and controller.high may widen"
        raise InputError(source, f"segment[{i}].{space.names[j]}", f"{values[i, j]:g} is not within {bounds}")
    return values


def differences(scenario: Scenario, saved: SavedParameters) -> tuple[str, ...]:
    """What is worth knowing about parameters that fit but were tuned for something else, one clause each."""
    remarks = []
    if saved.race != scenario.race.name:
        remarks.append(f"tuned for {saved.race}, used for {scenario.race.name}")
    mine, theirs = scenario.segments, saved.segments
    if mine.segment_classes != theirs.segment_classes:
        remarks.append(f"tuned for segments {', '.join(theirs.segment_classes)}, used for {', '.join(mine.segment_classes)}")
    elif saved.race == scenario.race.name and not _same_pieces(mine, theirs):
        remarks.append(f"tuned for segments that begin at {_starts(theirs)} s, used for {_starts(mine)} s")
    return tuple(remarks)


def _same_pieces(mine: Segments, theirs: Segments) -> bool:
    """Whether segments are the same parts of a flight, give or take what a plan may differ between machines."""
    alike = mine.owners == theirs.owners and len(mine.starts) == len(theirs.starts)
    return alike and bool(np.allclose(mine.starts, theirs.starts, rtol=0, atol=MOVED))


def _starts(segments: Segments) -> str:
    return ", ".join(f"{start:.1f}" for start in segments.starts)
