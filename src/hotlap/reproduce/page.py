"""Page: what an experiment found, for people."""

from __future__ import annotations

from hotlap.report.article import Article as Page

__all__ = ["Page", "percent"]


def percent(share: float) -> str:
    """A share as whole per cent."""
    return f"{100 * share:.0f}"
