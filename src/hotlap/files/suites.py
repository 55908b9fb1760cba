"""Suites: several built-in races by one word, the name of a suite or a pattern like circle-*."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path

from hotlap.core.errors import InputError
from hotlap.system.regular_files import is_there

SUITES: Mapping[str, tuple[str, ...]] = {
    "all": ("*",),
    "default": ("circle-20", "circle-34", "drop-20", "flip-16", "spiral-53", "qualifier-20", "final-22"),
    "airsim": ("airsim-*",),
    "real": ("real-*",),
}
"""Patterns of each: all races, those of the paper's Table I, those with AirSim's quadrotor, those with real gates."""


def expand(words: Iterable[str], known: Sequence[str], kind: str, suites: Mapping[str, Sequence[str]] = SUITES) -> list[str]:
    """Names for words, each once, in the order asked for; a word that is neither a suite nor a pattern stays as it is.

    Args:
        words: names, paths, suites or patterns.
        known: names of what is built in.
        kind: what these are, "race".
        suites: patterns by the names of suites.

    Raises:
        InputError: a pattern that matches nothing.
    """
    found: dict[str, None] = {}
    for word in words:
        patterns = suites.get(word, (word,))
        if word in suites or is_pattern(word):
            matched = [name for pattern in patterns for name in known if fnmatchcase(name, pattern)]
            if not matched:
                raise InputError(word, "", f"matches no built-in {kind}; hotlap {kind}s lists them")
            found |= dict.fromkeys(matched)
        else:
            found[word] = None
    return list(found)


def is_pattern(word: str) -> bool:
    """Whether a word is a pattern, and not the name of a file that has such characters."""
    return any(mark in word for mark in "*?[") and not is_there(Path(word))
