"""Wording: how numbers are shown."""

from __future__ import annotations

DIGITS = 4


def number(value: float) -> str:
    """A value with four digits."""
    return f"{value:.{DIGITS}g}"
