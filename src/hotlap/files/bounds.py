"""Bounds: what the content of a file may hold, so that whatever reads, shows or writes it can."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from hotlap.core.errors import InputError

DEEPEST = 100  # tables and lists within one another
BITS = 64  # of a whole number, as TOML says
LONGEST = 10_000  # entries of a list or table
MOST = 200_000  # values in all
_BEFORE_KEY = re.compile(r"[,{]")


def deep_key(text: str) -> int:
    """The line of TOML, from 1, with a dotted key of more parts than tables may be nested, which takes parsers long; 0 without one."""
    for number, line in enumerate(text.split("\n"), 1):
        if line.count(".") >= DEEPEST and not line.lstrip().startswith("#"):
            heads = [line] if line.lstrip().startswith("[") and "=" not in line else line.split("=")[:-1]
            if any(_BEFORE_KEY.split(head)[-1].count(".") >= DEEPEST for head in heads):
                return number
    return 0


def keep_bounds(content: Any, source: str) -> Any:
    """A file's content as it is.

    Raises:
        InputError: tables and lists are nested too deeply, are too long, or a whole number is beyond all bounds; with its key.
    """
    level, count = [("", content)], 0
    for _ in range(DEEPEST):
        long = next((key for key, held in level if len(held) > LONGEST), None)
        if long is not None:
            raise InputError(source, long, f"must have at most {LONGEST} entries")
        count += sum(len(held) for _, held in level)
        if count > MOST:
            raise InputError(source, "", f"holds more than {MOST} values")
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
