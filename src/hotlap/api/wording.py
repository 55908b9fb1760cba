"""Wording: figures as people read them, the same on the command line and in notebooks."""

from __future__ import annotations

import math

from hotlap.core.counts import count
from hotlap.core.success_rate import Validation


def percent(share: float) -> str:
    """A share of 1 for people; never rounded up to all of it."""
    return f"{100 * share:.3g} %" if share in {0.0, 1.0} or 0.001 <= share <= 0.999 else f"{100 * share:.6g} %"


def seconds(value: float, digits: int = 2) -> str:
    """A time, or a dash where there is none."""
    return f"{value:.{digits}f} s" if math.isfinite(value) else "-"


def duration(value: float) -> str:
    """How long something takes, roughly: 40 s, 6 min, 2.5 h."""
    if value < 100:
        return f"{value:.0f} s"
    return f"{value / 60:.0f} min" if value < 100 * 60 else f"{value / 3600:.1f} h"


def share(validation: Validation) -> str:
    """A rate with its interval: 97 % of 200 flights [94, 99]."""
    low, high = validation.interval
    return f"{percent(validation.rate)} of {count(validation.flights, 'flight')} [{100 * low:.0f}, {100 * high:.0f}]"
