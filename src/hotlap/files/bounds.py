"""Bounds: what the content of a file may hold, so that whatever reads, shows or writes it can."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from hotlap.core.errors import InputError

DEEPEST = 100  # tables and lists within one another
BITS = 64  # of a whole number, as TOML says


def keep_bounds(content: Any, source: str) -> Any:
    """A file's content as it is.

    Raises:
        InputError: tables and lists are nested too deeply, or a whole number is beyond all bounds; with its key.
    """
    level = [("", content)]
    for _ in range(DEEPEST):
        inner = [item for key, held in level for item in _items(key, held)]
        for key, item in inner:
            if isinstance(item, int) and item.bit_length() > BITS:
                raise InputError(source, key, f"must be a whole number of at most {BITS} bits")
        level = [(key, item) for key, item in inner if isinstance(item, dict | list)]
        if not level:
            return content
    raise InputError(source, "", "is nested too deeply")


def _items(key: str, held: dict[str, Any] | list[Any]) -> Iterator[tuple[str, Any]]:
    """What a table or list holds, with dotted keys."""
    if isinstance(held, dict):
        return ((f"{key}.{name}" if key else name, item) for name, item in held.items())
    return ((f"{key}[{k}]", item) for k, item in enumerate(held))
