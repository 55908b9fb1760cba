"""Counts: numbers of things in words."""

from __future__ import annotations


def count(number: int, noun: str) -> str:
    """A number of things: 1 flight, 2 flights."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
