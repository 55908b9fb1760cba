"""TOML writer: for the types that descriptions and parameters need; `tomllib` reads them."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def write(table: Mapping[str, Any], *, inline_lists: bool = False) -> str:
    """A table as a TOML document that reads back equal, floats bit for bit; values of None are left out.

    Args:
        table: strings, booleans, integers, floats, and lists and tables of them.
        inline_lists: write a list of tables as people write gates, a line for each, in place of `[[key]]`.
    """
    return "\n".join(_lines(table, "", inline_lists)).strip("\n") + "\n"


def write_value(value: Any) -> str:
    """One value on one line: `[1.0, 2.0]`, `"x"`, `{ base = "circle" }`."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(str(value), ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        pairs = ", ".join(f"{write_key(key)} = {write_value(item)}" for key, item in value.items() if item is not None)
        return f"{{ {pairs} }}" if pairs else "{}"
    if isinstance(value, Sequence):
        return f"[{', '.join(write_value(item) for item in value)}]"
    return repr(int(value)) if isinstance(value, int) else repr(float(value))


def write_key(key: str) -> str:
    """A key, in quotation marks where it needs them."""
    return key if _BARE.fullmatch(key) else write_value(key)


def write_pair(key: str, value: Any) -> str:
    """A key with its value; a list of lists or of tables takes a line for each, as people write gates."""
    return f"{write_key(key)} = {_broken(value)}"


def _lines(table: Mapping[str, Any], path: str, inline_lists: bool) -> list[str]:
    """Values first, then tables, then arrays of tables: what follows a header belongs to it."""
    values, tables, arrays = [], [], []
    for key, value in table.items():
        name = f"{path}.{write_key(key)}" if path else write_key(key)
        if isinstance(value, Mapping):
            tables += ["", f"[{name}]", *_lines(value, name, inline_lists)]
        elif not inline_lists and _is_array_of_tables(value):
            for item in value:
                arrays += ["", f"[[{name}]]", *_lines(item, name, inline_lists)]
        elif value is not None:
            values.append(write_pair(key, value))
    return values + tables + arrays


def _is_array_of_tables(value: Any) -> bool:
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(item, Mapping) for item in value)


def _broken(value: Any) -> str:
    """A list of lists or of tables, on a line for each."""
    if isinstance(value, (list, tuple)) and any(isinstance(item, (list, tuple, Mapping)) for item in value):
        return "[\n" + "".join(f"  {write_value(item)},\n" for item in value) + "]"
    return write_value(value)
