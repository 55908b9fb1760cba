"""Shown: short forms of what a program hands out, for prompts and notebooks, and data frames of what comes in rows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard, TypeVar

from hotlap.core.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd  # pyright: ignore[reportMissingImports]

LONGEST = 399  # characters of a short form
VALUE = 60  # of a value in it
FEW = 8  # numbers that are shown one by one

Item = TypeVar("Item", covariant=True)  # noqa: PLC0105  as of a tuple


class Shown:
    """Something that a prompt and a notebook show in fewer than 400 characters, value by value."""

    def __repr__(self) -> str:
        return fitted(f"{type(self).__name__}(", [f"{name}={brief(value)}" for name, value in _values(self)], ")")

    def __str__(self) -> str:
        return repr(self)

    def _repr_html_(self) -> str:
        return html_table(type(self).__name__, [(name, brief(value)) for name, value in _values(self)])


class Framed:
    """Something that comes in rows."""

    def records(self) -> list[dict[str, Any]]:
        """A row for each, plain values by column."""
        raise NotImplementedError

    def to_frame(self) -> pd.DataFrame:
        """The rows as a pandas data frame.

        Raises:
            InputError: pandas is not installed.
        """
        return frame(self.records())


class Listed(tuple[Item, ...], Framed):
    """A tuple of results, with a short form and a data frame of its own."""

    __slots__ = ()

    def __repr__(self) -> str:
        return fitted(f"<{_count(self)}{': ' if self else ''}", [_name(one) or brief(one) for one in self], ">", "; ")

    def _repr_html_(self) -> str:
        return html_table(_count(self), [(_name(one) or str(i), brief(one)) for i, one in enumerate(self)])

    def records(self) -> list[dict[str, Any]]:
        """A row for each, in the keys of `--json` where it has such."""
        return [flat(one) for one in self]


def frame(rows: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """Rows as a pandas data frame.

    Raises:
        InputError: pandas is not installed.
    """
    try:
        import pandas as pd  # noqa: PLC0415  # pyright: ignore[reportMissingImports]  not needed for anything else, and slow to load
    except ImportError:
        raise InputError("", "to_frame", "needs pandas: pip install pandas; rows() and records() give the same as plain values") from None
    return pd.DataFrame(rows)


def by_column(columns: Mapping[str, Iterable[Any]]) -> list[dict[str, Any]]:
    """Rows of plain values, from columns of one length; arrays are made lists."""
    plain = [values.tolist() if _is_array(values) else list(values) for values in columns.values()]
    return [dict(zip(columns, row, strict=True)) for row in zip(*plain, strict=True)]


def flat(one: Any) -> dict[str, Any]:
    """One result as a row: what it dumps, or its attributes; what is nested gets dotted names."""
    dump, change = getattr(one, "dump", None), getattr(one, "change", None)
    named = {} if change is None else {"change": change}
    told: Mapping[str, Any] = dump() if callable(dump) else dict(_values(one))  # pyright: ignore[reportAssignmentType]
    return dict(_leaves({**named, **told}, ""))


def fitted(head: str, parts: Sequence[str], tail: str, between: str = ", ") -> str:
    """Parts between a head and a tail, as many as make fewer than 400 characters."""
    text = f"{head}{between.join(parts)}{tail}"
    left = len(parts)
    while len(text) > LONGEST and left:
        left -= 1
        text = f"{head}{between.join([*parts[:left], '...'])}{tail}"
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 4]} ...{tail[-1:]}"[-LONGEST:]


def html_table(title: str, rows: Sequence[tuple[str, str]]) -> str:
    """A table with a caption, in fewer than 400 characters: a row that does not fit is left out, a path to a page becomes a link."""
    head, tail = f"<table><caption>{escape(_cut(title, 2 * VALUE))}</caption>", "</table>"
    written, more = "", "<tr><td>..."
    for name, value in rows:
        row = f"<tr><th>{escape(name)}<td>{_linked(value)}"
        if len(head + written + row + more + tail) <= LONGEST:
            written += row
        elif not written.endswith(more):
            written += more
            more = ""
    return head + written + tail


def brief(value: Any) -> str:
    """A value in at most 60 characters."""
    if isinstance(value, str) and not isinstance(value, Enum):
        return repr(_cut(value, VALUE - 4))
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, bool | int | None):
        return repr(value)
    if isinstance(value, float):
        return f"{value:.6g}"
    if _is_array(value):
        return _array(value)
    if isinstance(value, Path):
        return _cut(str(value), VALUE)
    if isinstance(value, Mapping):
        return f"<{len(value)} entries>" if value else "{}"
    if isinstance(value, tuple | list):
        text = f"({', '.join(map(brief, value[: FEW + 1]))})"
        return text if len(value) <= FEW and len(text) <= VALUE else f"<{_count(value)}>"
    return _cut(f"<{' '.join(filter(None, (type(value).__name__, _name(value))))}>", VALUE)


def in_full(value: Any) -> str:
    """A value to its last digit, for digests: unlike its short form it differs wherever anything in it differs."""
    if _is_array(value):
        return f"{value.dtype}{value.shape}{value.tobytes().hex()}"
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{in_full(key)}: {in_full(one)}' for key, one in value.items())}}}"
    if isinstance(value, tuple | list | set | frozenset):
        return f"({', '.join(map(in_full, value))})"
    if isinstance(value, Shown) or (is_dataclass(value) and not isinstance(value, type)):
        return f"{type(value).__qualname__}({', '.join(f'{name}={in_full(one)}' for name, one in _values(value))})"
    return repr(value)


def _values(one: Any) -> list[tuple[str, Any]]:
    """The values that something is made of, by name."""
    names = [field.name for field in fields(one)] if is_dataclass(one) else list(vars(one))
    return [(name, getattr(one, name)) for name in names if not name.startswith("_")]


def _leaves(value: Any, name: str) -> Iterable[tuple[str, Any]]:
    """What a row holds, by dotted name."""
    if isinstance(value, Mapping) and (value or not name):
        for key, one in value.items():
            yield from _leaves(one, f"{name}.{key}" if name else str(key))
    elif is_dataclass(value) and not isinstance(value, type):
        yield from _leaves(dict(_values(value)), name)
    else:
        yield name, value.value if isinstance(value, Enum) else value


def _name(one: Any) -> str:
    """What something is called, if it has a name of its own."""
    found = [getattr(one, key, None) for key in ("name", "change", "label", "place", "found")]
    runs = " ".join(str(getattr(one, key, "")) for key in ("race", "tuner")) if hasattr(one, "tuner") else ""
    return _cut(next((name for name in [*found, runs] if isinstance(name, str) and name), ""), VALUE)


def _count(values: Sequence[Any]) -> str:
    """How many there are, and of what kind."""
    kinds = {type(one).__name__ for one in values}
    return f"{len(values)} {kinds.pop()}" if len(kinds) == 1 else f"{len(values)} values"


def _is_array(value: Any) -> TypeGuard[np.ndarray]:
    """Whether a value is an array of numpy."""
    return type(value).__module__ == "numpy" and hasattr(value, "tobytes") and hasattr(value, "ndim")


def _array(values: np.ndarray) -> str:
    """Some numbers, or how many there are."""
    if values.size > FEW or values.ndim > 2:
        return f"<{' x '.join(map(str, values.shape))} numbers>"
    import numpy as np  # noqa: PLC0415  whoever has an array has loaded it; names alone need none of it

    text = np.array2string(values, precision=4, separator=", ").replace("\n", "")
    return text if len(text) <= VALUE else f"<{' x '.join(map(str, values.shape))} numbers>"


def _cut(text: str, longest: int) -> str:
    return text if len(text) <= longest else f"{text[: longest - 4]} ..."


def _linked(value: str) -> str:
    """A path to a page is a link to it, under the name of its file."""
    if not value.endswith(".html"):
        return escape(_cut(value, 2 * VALUE))
    return f'<a href="{escape(Path(value).as_posix(), quote=True)}">{escape(Path(value).name)}</a>'
