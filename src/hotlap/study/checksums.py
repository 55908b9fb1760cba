"""Checksums: what a row of a study held when it was written, so that a bit that has flipped since is found."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterable
from typing import Any


def checksum(values: Iterable[Any], before: int = 0) -> int:
    """The CRC-32 of values as SQLite gives them back; in a chain, rows that are missing or in another order are found, too.

    Args:
        values: of a row: numbers, texts, bytes and None.
        before: that of the row before, in a chain.
    """
    return zlib.crc32(repr([_as_kept(value) for value in values]).encode(), before)


def _as_kept(value: Any) -> Any:
    """A value as it comes back: NaN as None, -0.0 as 0.0, True as 1."""
    if isinstance(value, float):
        return None if math.isnan(value) else value + 0.0
    return int(value) if isinstance(value, bool) else value
