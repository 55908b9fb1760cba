"""Listing: what is built in, all of it or what matches patterns."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from hotlap.core.errors import UnknownNameError
from hotlap.files.suites import SUITES, expand

LONGEST = 30  # characters of a provenance


def chosen(words: Sequence[str], known: Sequence[str], kind: str, suites: Mapping[str, Sequence[str]] = SUITES) -> list[str]:
    """Names that match any of the words; all without words.

    Raises:
        InputError: a word that matches nothing.
    """
    if not words:
        return list(known)
    names = expand(words, known, kind, suites)
    for name in names:
        if name not in known:
            raise UnknownNameError(kind, name, known)
    return names


def shorten(text: str, longest: int = LONGEST) -> str:
    """The first clause, or as much of it as fits."""
    clause = text.partition(". ")[0].partition("; ")[0].rstrip(".")
    kept = clause[: longest - 4]
    return clause if len(clause) <= longest else (kept.rpartition(" ")[0] or kept) + " ..."


def described(docstring: str | None) -> str:
    """The first paragraph of what a module says of itself, without what stands in brackets."""
    return re.sub(r" ?\([^()]*(\([^()]*\)[^()]*)*\)", "", " ".join((docstring or "").partition("\n\n")[0].split()))


def show(value: str | float | None) -> str:
    """A value in a cell."""
    return "-" if value is None else value if isinstance(value, str) else f"{value:g}"
