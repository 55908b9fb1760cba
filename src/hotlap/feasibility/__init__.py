"""Feasibility: what a file means, and whether what it asks for can be flown, as far as figures tell before anything is tuned.

for finding in describe(load_race("my-race.toml")):
    print(finding.label, finding.value, finding.remark)
"""

from __future__ import annotations

import numpy as np

from hotlap.feasibility.finding import Finding, Level
from hotlap.feasibility.quadrotor import describe_quadrotor
from hotlap.feasibility.race import describe_race
from hotlap.feasibility.track import describe_track
from hotlap.files.descriptions import Description
from hotlap.race.quadrotor import Quadrotor
from hotlap.race.track import Track

__all__ = ["Finding", "Level", "describe"]


def describe(description: Description, top_speed: float | None = None) -> tuple[Finding, ...]:
    """What a description means, in the order in which one would ask; nothing is planned or flown.

    Args:
        description: a track, a quadrotor or a race.
        top_speed: [m/s] of the race's plan where there is one; else a rough estimate stands in.
    """
    with np.errstate(all="ignore"):  # of numbers that cannot be right the findings speak
        if isinstance(description, Track):
            return describe_track(description)
        if isinstance(description, Quadrotor):
            return describe_quadrotor(description)
        return describe_race(description, top_speed)
