"""Segmentation: a reference is cut into segments, which have parameters of their own, by one of several rules."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial

from hotlap.reference.reference import Reference
from hotlap.reference.segmentation_rule import SegmentationRule
from hotlap.reference.segmentation_rules import by_height, by_time
from hotlap.reference.segments import Piece, SegmentClass, Segments

__all__ = ["Piece", "SegmentClass", "SegmentationRule", "Segments", "segment"]


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
