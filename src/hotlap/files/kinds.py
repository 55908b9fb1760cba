"""Kinds of files by name; imports nothing that takes time."""

from __future__ import annotations

from enum import StrEnum


class Kind(StrEnum):
    """What a file describes."""

    RACE = "race"
    TRACK = "track"
    QUADROTOR = "quadrotor"
