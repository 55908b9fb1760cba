"""Segmentation: a reference is cut into segments, which have parameters of their own, by one of several rules."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from enum import StrEnum
from functools import partial

from hotlap.reference.reference import Reference
from hotlap.reference.segmentation_rules import by_height, by_time
from hotlap.reference.segments import Piece, SegmentClass, Segments

__all__ = ["Piece", "SegmentClass", "SegmentationRule", "Segments", "segment"]


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


RULES: Mapping[SegmentationRule, Callable[..., Segments]] = {
    SegmentationRule.PAPER: by_height,
    SegmentationRule.RELEASED_1M: partial(by_height, rise=1.0, ahead=1.0, slope=math.inf),
    SegmentationRule.RELEASED_3M: partial(by_height, rise=3.0, ahead=1.02, slope=math.inf),
    SegmentationRule.NONE: partial(by_time, piece=math.inf),
    SegmentationRule.EQUAL_TIME: by_time,
}


def segment(reference: Reference, rule: SegmentationRule = SegmentationRule.PAPER, **thresholds: float) -> Segments:
    """Cut a plan into segments; its run-out belongs to the last piece.

    Args:
        reference: what is cut.
        rule: how.
        thresholds: other than the rule's own, by the names that its function in `segmentation_rules` gives them.
    """
    return RULES[rule](reference, **thresholds)
