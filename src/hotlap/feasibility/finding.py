"""Finding: one line about a track, a quadrotor, a race, its plan or its flights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from hotlap.core.shown import Shown


class Level(StrEnum):
    """How much a finding matters."""

    FACT = "fact"
    NOTE = "note"
    WARNING = "warning"


@dataclass(frozen=True, repr=False)
class Finding(Shown):
    """One line about a description.

    Attributes:
        label: what it is about.
        value: the figure with its unit.
        remark: what it means, or "".
        level: how much it matters.
        figures: the figures of `value` for programs, by names that end with their unit: `top_speed_m_per_s`; without one they are
            shares or counts.
    """

    label: str
    value: str
    remark: str = ""
    level: Level = Level.FACT
    figures: Mapping[str, float] = field(default_factory=dict)


def note_if(condition: bool) -> Level:
    """A note where something holds, else a fact."""
    return Level.NOTE if condition else Level.FACT


def warning_if(condition: bool) -> Level:
    """A warning where something holds, else a fact."""
    return Level.WARNING if condition else Level.FACT
