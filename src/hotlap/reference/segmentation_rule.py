"""Segmentation rules by name; imports nothing that takes time."""

from __future__ import annotations

from enum import StrEnum


class SegmentationRule(StrEnum):
    """How a reference is cut.

    PAPER: by height, Sec. IV-C: 1 m within 1 s, at least 2 s, steep pieces halved.
    RELEASED_1M: as one of the released code's files: 1 m within 100 samples, nothing halved. Its pieces last 2 s here too, which the
        released code does not say.
    RELEASED_3M: as another: 3 m within 102 samples.
    NONE: one segment, of the class that most of its rows are.
    EQUAL_TIME: pieces of equal time, of about 2 s, whatever they do.
    """

    PAPER = "paper"
    RELEASED_1M = "released_1m"
    RELEASED_3M = "released_3m"
    NONE = "none"
    EQUAL_TIME = "equal_time"
